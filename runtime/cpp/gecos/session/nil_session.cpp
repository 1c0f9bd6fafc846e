#include "gecos/session/linked_session.hpp"

namespace gecos::session {
namespace {

class NilSession final : public ClientSession {
 public:
  std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t /*size*/,
                                    FunctionRef<void(wire::Encoder&)> /*encode*/,
                                    const CallOptions& /*options*/) override {
    return ended(why("'" + std::string(operation.name) + "' was called"));
  }
  tl::expected<std::shared_ptr<StreamCore>, Failure> subscribe(
      const StreamDescription& stream) override {
    return tl::unexpected(why("'" + std::string(stream.name) + "' was subscribed to"));
  }
  const std::string& interface_name() const override { return nothing_; }
  const std::string& object_name() const override { return nothing_; }
  const media::Offer& offer() const override { return offer_; }
  std::uint64_t hold(std::uint64_t /*epoch*/) override { return 0; }
  void let_go(std::uint64_t /*held*/) override {}

 private:
  static Failure why(const std::string& what) {
    return {Detail::NoServer,
            what + " on a proxy that names no object; get one from Lab::create", {}, {}};
  }
  const std::string nothing_;
  const media::Offer offer_;
};

}  // namespace

std::shared_ptr<CommandCore> ended(Failure failure) {
  return std::make_shared<PendingCommand>(std::move(failure));
}

const std::shared_ptr<ClientSession>& nil_session() {
  static const std::shared_ptr<ClientSession> nil = std::make_shared<NilSession>();
  return nil;
}

}  // namespace gecos::session
