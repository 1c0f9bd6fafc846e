#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/function_ref.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/session/client/client_stream.hpp"
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

/// A subscription through a session that may move to another medium. The samples have the same
/// numbers over all media. So the reader continues after the last sample that it has read, gets no
/// sample twice, and is told how many samples it has missed. Thread-safe like every StreamCore.
class MovableStream final : public StreamCore {
 public:
  /// `session`: the session that moves this stream. The stream keeps it open.
  MovableStream(std::shared_ptr<ClientSession> session, Runtime& runtime,
                const StreamDescription& stream, std::shared_ptr<ClientStream> opened)
      : session_(std::move(session)),
        runtime_(runtime),
        stream_(stream),
        read_(opened),
        core_(std::move(opened)) {}

  const StreamDescription& description() const { return stream_; }
  std::shared_ptr<ClientStream> core() const;
  /// From now on the reader reads from `core`, a subscription to the same stream over another
  /// medium. Any thread may call this function.
  void go_on_in(std::shared_ptr<ClientStream> core);

  bool latest(RawSample& into) override;
  tl::expected<void, StreamEnd> next(RawSample& into, TimePoint deadline) override;
  bool lend_latest(RawLent& into) override;
  tl::expected<void, StreamEnd> lend_next(RawLent& into, TimePoint deadline) override;
  std::vector<RawSample> history() override;
  void stop_waiting() override;
  bool lost() const override { return core()->lost(); }
  std::string loss_text() const override { return core()->loss_text(); }
  bool revoked() const override { return core()->revoked(); }
  std::optional<std::uint64_t> after() const override { return core()->after(); }
  qos::StreamCounts counts() const override { return core()->counts(); }
  bool alive() const override { return core()->alive(); }
  std::string title() const override { return core()->title(); }

 private:
  tl::expected<void, StreamEnd> next_of(const std::uint64_t& sequence,
                                        FunctionRef<tl::expected<void, StreamEnd>()> read);
  void read_from(std::shared_ptr<ClientStream> core);

  const std::shared_ptr<ClientSession> session_;
  Runtime& runtime_;
  const StreamDescription& stream_;
  std::shared_ptr<ClientStream> read_;  ///< what the reader reads; used by the reader only
  mutable FutexMutex mutex_;
  std::shared_ptr<ClientStream> core_ GECOS_GUARDED_BY(mutex_);
  bool stopped_ GECOS_GUARDED_BY(mutex_) = false;  ///< stop_waiting() was called
};

}  // namespace gecos::session
