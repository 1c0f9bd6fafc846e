#pragma once

#include <memory>
#include <optional>

#include "gecos/object.hpp"
#include "gecos/writer.hpp"

namespace gecos::session {

class ClientConnection;

/// The client side of one inward stream.
class ClientWriter final : public WriterCore {
 public:
  /// Opens `stream` and waits until the server reads it.
  static tl::expected<std::shared_ptr<WriterCore>, Failure> open(
      std::shared_ptr<ClientConnection> session, const InwardDescription& stream);
  ClientWriter(std::shared_ptr<ClientConnection> session, const InwardDescription& stream,
               std::unique_ptr<media::StreamWriter> writer, std::uint32_t id);
  ~ClientWriter() override;

  tl::expected<void, Failure> send(std::size_t size, FunctionRef<void(wire::Encoder&)> encode,
                                   std::int64_t stamp_ns) override;
  void feeds(std::optional<CommandId> id) override;
  Command<FeedReport> report() override;
  bool lost() const override;

 private:
  std::optional<Failure> await_reader();
  std::string what() const;
  tl::unexpected<Failure> not_sent(Detail detail, const std::string& why) const;

  const std::shared_ptr<ClientConnection> session_;
  const InwardDescription& stream_;
  const std::unique_ptr<media::StreamWriter> writer_;
  const std::uint32_t id_;
  bool opened_ = false;
  std::optional<CommandId> fed_;
};

}  // namespace gecos::session
