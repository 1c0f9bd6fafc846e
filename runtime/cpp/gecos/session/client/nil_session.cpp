#include <atomic>

#include "gecos/session/client/client_connection.hpp"

namespace gecos::session {
namespace {

/// A session without a server. Every call and subscription fails at once with the same reason.
class NilSession final : public ClientSession {
 public:
  explicit NilSession(std::string reason) : reason_(std::move(reason)) {}
  NilSession(std::string reason, const ClientSession& was)
      : reason_(std::move(reason)),
        interface_name_(was.interface_name()),
        object_name_(was.object_name()),
        capabilities_(was.capabilities()),
        reference_(was.reference()) {}

  std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t /*size*/,
                                    FunctionRef<void(wire::Encoder&)> /*encode*/,
                                    const CallOptions& /*options*/) override {
    return ended(why("'" + std::string(operation.name) + "'" + of_object() + " was called"));
  }
  std::shared_ptr<CommandCore> refuse(const OperationDescription& /*operation*/,
                                      Failure failure) override {
    return ended(std::move(failure));
  }
  tl::expected<std::shared_ptr<StreamCore>, Failure> subscribe(
      const StreamDescription& stream) override {
    return tl::unexpected(
        why("'" + std::string(stream.name) + "'" + of_object() + " was subscribed to"));
  }
  tl::expected<std::shared_ptr<WriterCore>, Failure> open_writer(
      const InwardDescription& stream) override {
    return tl::unexpected(why("'" + std::string(stream.name) + "'" + of_object() + " was opened"));
  }
  const std::string& interface_name() const override { return interface_name_; }
  const std::string& object_name() const override { return object_name_; }
  const media::Capabilities& capabilities() const override { return capabilities_; }
  ObjectRef reference() const override { return reference_; }
  std::uint64_t lease_acquired(std::uint64_t /*epoch*/) override { return 0; }
  void lease_released(std::uint64_t /*held*/) override {}
  std::uint64_t issued() override { return 0; }

 private:
  std::string of_object() const { return object_name_.empty() ? "" : " of " + object_name_; }
  Failure why(const std::string& what) const {
    return {Detail::NoServer, what + " on " + reason_, {}, {}};
  }

  const std::string reason_;
  const std::string interface_name_;
  const std::string object_name_;
  const media::Capabilities capabilities_;
  const ObjectRef reference_;
};

}  // namespace

std::shared_ptr<CommandCore> ended(Failure failure) {
  return std::make_shared<PendingCommand>(std::move(failure));
}

namespace {
std::atomic<std::uint64_t> refused_calls{0};  // orders no other memory
}

Refused::Refused(std::string why, ClientSession& session, const OperationDescription& operation)
    : core_(session.refuse(operation, {Detail::BadParameter, std::move(why), {}, {}})) {
  refused_calls.fetch_add(1, std::memory_order_relaxed);
}

Refused::Refused(std::string why) : core_(ended({Detail::BadParameter, std::move(why), {}, {}})) {
  refused_calls.fetch_add(1, std::memory_order_relaxed);
}

std::uint64_t Refused::count() { return refused_calls.load(std::memory_order_relaxed); }

const std::shared_ptr<ClientSession>& nil_session() {
  static const std::shared_ptr<ClientSession> nil = std::make_shared<NilSession>(
      "a proxy that refers to no object; get a proxy from Lab::create");
  return nil;
}

std::shared_ptr<ClientSession> closed_session(const ClientSession& was) {
  return std::make_shared<NilSession>(
      "a proxy whose Lab is closed; keep the Lab open while its proxies are used, or create a new "
      "Lab and a new proxy",
      was);
}

}  // namespace gecos::session
