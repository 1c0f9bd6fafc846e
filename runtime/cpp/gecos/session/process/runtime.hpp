#pragma once

#include <atomic>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/binding.hpp"
#include "gecos/lab.hpp"
#include "gecos/media/kinds.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/process/callbacks.hpp"
#include "gecos/session/process/maintenance.hpp"
#include "gecos/session/protocol/handshake.hpp"

namespace gecos::session {

/// A session that can be closed in order, for example when the program exits.
class Closable {
 public:
  virtual ~Closable() = default;
  /// Closes the session; waits at most `patience` for the peer.
  virtual void close(Duration patience) = 0;
};

/// The resources that the sessions and servers of one lab share: settings, the clock, the media and
/// the maintenance thread. Lives until the last session and the last server are destroyed.
/// Thread-safe.
class Runtime : public std::enable_shared_from_this<Runtime> {
 public:
  /// Creates a runtime whose sessions say goodbye when the program exits, even if their Lab is
  /// never destroyed. Fails when this process has no thread or descriptor left for the runtime.
  static tl::expected<std::shared_ptr<Runtime>, NoLab> make(LabOptions options, const Clock& clock,
                                                            media::WrapMedium wrap = {});

  Runtime(LabOptions options, const Clock& clock, media::WrapMedium wrap = {});
  ~Runtime();

  const LabOptions& options() const { return options_; }
  const Clock& clock() const { return clock_; }
  /// Returns the anchor of the heartbeats of a new session that sends them as packets; it is never
  /// later than now. Of ten anchors, `heartbeats_in_step` successive sessions have the same one, so
  /// that one wake-up sends many heartbeats, but the heartbeats of a thousand sessions are spread
  /// over the period. Sessions that have ended count, too.
  TimePoint heartbeat_anchor();
  static constexpr std::size_t heartbeats_in_step = 64;
  Maintenance& maintenance() { return maintenance_; }
  Callbacks& callbacks() { return callbacks_; }
  /// Returns the time of silence after which a session ends. If a server was silent for this time,
  /// the broker also drops the registrations that the server made in the session.
  Duration registration_ttl() const { return options_.lease_ttl + options_.grace; }

  /// Returns the medium `kind`, which is opened at its first use. On failure returns why the medium
  /// is not available to this program now.
  tl::expected<media::Medium*, media::MediumError> medium(media::Kind kind);
  /// Returns a text that identifies the host and the runtime directory. Two programs have equal
  /// texts exactly when they can reach each other over shared memory.
  const std::string& host_identity();
  /// Returns the Hello with which this program opens a session with an object of the interface
  /// `wanted`.
  Hello introduce(const InterfaceDescription& wanted) const;

  /// Registers `session` to be closed when this program exits, if the session still exists then.
  void close_at_exit(const std::shared_ptr<Closable>& session);
  /// Closes the sessions one after the other within `patience`. Each session gets at least two
  /// heartbeat periods, so that a server that does not answer takes no time away from the other
  /// sessions.
  void close_all(const std::vector<std::shared_ptr<Closable>>& sessions, Duration patience) const;
  /// Says goodbye in every open session.
  void close_sessions(Duration patience);

 private:
  const LabOptions options_;
  const Clock& clock_;
  const TimePoint made_ = clock_.now();
  std::atomic<std::size_t> sessions_in_packets_{0};  // orders no other memory
  const media::WrapMedium wrap_;  ///< set by tests only; null: media are used unwrapped
  Mutex mutex_;
  std::map<media::Kind, std::unique_ptr<media::Medium>> media_ GECOS_GUARDED_BY(mutex_);
  std::optional<std::string> host_identity_ GECOS_GUARDED_BY(mutex_);
  std::vector<std::weak_ptr<Closable>> sessions_ GECOS_GUARDED_BY(mutex_);
  Callbacks callbacks_;
  Maintenance maintenance_;  ///< last member, so that its thread ends first
};

}  // namespace gecos::session
