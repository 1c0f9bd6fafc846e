#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "gecos/object.hpp"
#include "gecos/stream.hpp"

namespace gecos::session {

class ClientConnection;

/// The client side of a subscription to a stream.
class ClientStream final : public StreamCore {
 public:
  /// `after`: see StreamCore::after().
  ClientStream(std::shared_ptr<ClientConnection> session, const StreamDescription& stream,
               std::unique_ptr<media::StreamReader> reader, std::optional<std::uint64_t> after);
  ~ClientStream() override;

  bool latest(RawSample& into) override;
  tl::expected<void, StreamEnd> next(RawSample& into, TimePoint deadline) override;
  bool lost() const override;
  std::optional<std::uint64_t> after() const override { return after_; }
  qos::StreamCounts counts() const override { return reception_.counts(); }
  bool alive() const override { return !lost() && reception_.writer_alive(); }

 private:
  bool await_sample(RawSample& into, TimePoint deadline);
  bool admit(qos::Reception::Way way, RawSample& sample, TimePoint now);

  const std::shared_ptr<ClientConnection> session_;
  const FunctionCode code_;
  const std::unique_ptr<media::StreamReader> reader_;
  const std::optional<std::uint64_t> after_;
  qos::Reception reception_;
};

}  // namespace gecos::session
