#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/object.hpp"
#include "gecos/qos/failover_plan.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/movable_stream.hpp"
#include "gecos/session/client/status_use.hpp"

namespace gecos::session {

/// The session of a proxy whose interface has `@qos(on_degraded="failover")`. When the connection
/// becomes degraded, this class opens another session with the same object over another medium that
/// meets the quality. From then on, the new session carries the calls and the streams. Calls that
/// were issued before the move end in the old session, which stays open until they have ended.
/// While the program has a status or writes an inward stream, the session stays on its medium.
/// Thread-safe.
class MovableSession final : public ClientSession,
                             public TickTarget,
                             public std::enable_shared_from_this<MovableSession> {
 public:
  /// `must_stay`: why the session may never move to another medium; empty when it may.
  MovableSession(Context& lab, std::shared_ptr<ClientConnection> session, std::string must_stay);

  std::shared_ptr<CommandCore> call(const OperationDescription& operation, std::size_t size,
                                    FunctionRef<void(wire::Encoder&)> encode,
                                    const CallOptions& options) override;
  std::shared_ptr<CommandCore> refuse(const OperationDescription& operation,
                                      Failure failure) override;
  tl::expected<std::shared_ptr<StreamCore>, Failure> subscribe(
      const StreamDescription& stream) override;
  tl::expected<std::shared_ptr<WriterCore>, Failure> open_writer(
      const InwardDescription& stream) override;
  const std::string& interface_name() const override { return interface_name_; }
  const std::string& object_name() const override { return object_name_; }
  const media::Capabilities& capabilities() const override;
  ObjectRef reference() const override { return current()->reference(); }
  std::uint64_t lease_acquired(std::uint64_t epoch) override;
  void lease_released(std::uint64_t held) override { current()->lease_released(held); }
  bool lease_lost(std::uint64_t held) const override { return current()->lease_lost(held); }
  LineState line() const override;
  LineState await_line_change(std::uint64_t changes, TimePoint deadline) const override;
  std::uint64_t issued() override;

  NextTick on_tick(TimePoint now) override;

 private:
  /// A stream of the program, and its new subscription over another medium.
  struct Resumed {
    std::shared_ptr<MovableStream> stream;
    std::shared_ptr<ClientStream> core;
  };
  /// The part of a LineState that this object adds to the state of the present connection.
  struct Report {
    std::uint64_t earlier = 0;  ///< number of changes, without those of the present connection
    std::uint64_t at = 0;  ///< number of changes of the present connection before the last report
    std::string moved_from{};
    std::string why{};
  };

  std::shared_ptr<ClientConnection> current() const;
  LineState line_now() const GECOS_REQUIRES(mutex_);
  std::string why_stay() GECOS_REQUIRES(mutex_);
  std::string report_stay(const std::string& why) GECOS_REQUIRES(mutex_);
  /// Looks for another medium, and moves the session to that medium. Blocks; called on the thread
  /// of the Failover.
  void search(Context& lab);
  void stay(const std::string& why);
  tl::expected<std::vector<Resumed>, Failure> resume_streams(ClientConnection& found)
      GECOS_REQUIRES(subscribing_);
  bool move_to(const std::shared_ptr<ClientConnection>& found);

  const std::string object_name_;
  const std::string interface_name_;
  const std::string must_stay_;
  const std::shared_ptr<Failover> failover_;

  /// Held while a stream is opened and while the session moves to another medium, so that no stream
  /// is left behind. Must be locked before `mutex_`.
  Mutex subscribing_;
  std::vector<std::weak_ptr<MovableStream>> streams_ GECOS_GUARDED_BY(subscribing_);

  mutable FutexMutex mutex_;
  std::shared_ptr<ClientConnection> current_ GECOS_GUARDED_BY(mutex_);
  /// The capabilities of each medium that was used. Callers keep references to the values, so no
  /// value is ever removed.
  mutable std::map<std::string_view, media::Capabilities> capabilities_ GECOS_GUARDED_BY(mutex_);
  /// Number of calls that were issued in the earlier sessions, which this object has left for
  /// another medium.
  std::uint64_t issued_before_ GECOS_GUARDED_BY(mutex_) = 0;
  StatusUse status_ GECOS_GUARDED_BY(mutex_);
  std::vector<std::weak_ptr<WriterCore>> writers_ GECOS_GUARDED_BY(mutex_);
  qos::FailoverPlan plan_ GECOS_GUARDED_BY(mutex_);
  Report report_ GECOS_GUARDED_BY(mutex_);
};

/// Returns the session for a proxy of the interface `wanted`. If the interface has
/// `on_degraded="failover"` and bounds the latency, this is a MovableSession that uses `session`;
/// otherwise it is `session` itself.
std::shared_ptr<ClientSession> with_failover(Context& lab,
                                             std::shared_ptr<ClientConnection> session,
                                             const InterfaceDescription& wanted);

}  // namespace gecos::session
