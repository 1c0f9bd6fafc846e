#pragma once

#include <atomic>
#include <memory>

#include "gecos/session/object.hpp"
#include "gecos/session/stream.hpp"

namespace gecos::session {

class LinkedSession;

/// A subscription of this process.
class ClientStream final : public StreamCore {
 public:
  ClientStream(std::shared_ptr<LinkedSession> session, FunctionCode code,
               std::unique_ptr<media::StreamReader> reader);
  ~ClientStream() override;

  bool latest(media::StreamSample& into) override;
  tl::expected<void, StreamEnd> next(media::StreamSample& into, TimePoint deadline) override;
  std::int64_t now_ns() const override;

  FunctionCode code() const { return code_; }
  /// The server closed it.
  void close() { closed_.store(true, std::memory_order_release); }

 private:
  const std::shared_ptr<LinkedSession> session_;
  const FunctionCode code_;
  const std::unique_ptr<media::StreamReader> reader_;
  std::atomic<bool> closed_{false};  // publishes nothing but itself
};

}  // namespace gecos::session
