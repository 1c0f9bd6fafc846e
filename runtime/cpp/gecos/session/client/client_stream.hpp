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
  ClientStream(std::shared_ptr<ClientConnection> session, FunctionCode code,
               std::unique_ptr<media::StreamReader> reader, std::optional<std::uint64_t> after);
  ~ClientStream() override;

  bool latest(RawSample& into) override;
  tl::expected<void, StreamEnd> next(RawSample& into, TimePoint deadline) override;
  bool lost() const override;
  std::optional<std::uint64_t> after() const override { return after_; }
  Duration age(const RawSample& sample) const override;

 private:
  void finish(RawSample& sample) const;

  const std::shared_ptr<ClientConnection> session_;
  const FunctionCode code_;
  const std::unique_ptr<media::StreamReader> reader_;
  const std::optional<std::uint64_t> after_;
};

}  // namespace gecos::session
