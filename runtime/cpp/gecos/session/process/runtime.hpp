#pragma once

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

/// Something open that ends in order when the program exits.
class Closable {
 public:
  virtual ~Closable() = default;
  /// Waits at most `patience` for the other end.
  virtual void close(Duration patience) = 0;
};

/// What sessions and servers of one lab share: settings, the clock, the media and the maintenance
/// thread. It lives as long as the last of them. Thread-safe.
class Runtime : public std::enable_shared_from_this<Runtime> {
 public:
  /// Creates a runtime whose sessions say goodbye when the program exits, however its labs are
  /// dropped. Fails when this process has no thread or descriptor left for it.
  static tl::expected<std::shared_ptr<Runtime>, NoLab> make(LabOptions options, const Clock& clock);

  Runtime(LabOptions options, const Clock& clock);
  ~Runtime();

  const LabOptions& options() const { return options_; }
  const Clock& clock() const { return clock_; }
  Maintenance& maintenance() { return maintenance_; }
  Callbacks& callbacks() { return callbacks_; }
  /// Silence after which a session ends, and with it what a server registered with a broker.
  Duration registration_ttl() const { return options_.lease_ttl + options_.grace; }

  /// The medium of this kind, opened at first use, or why it is not available here now.
  tl::expected<media::Medium*, media::MediumError> medium(media::Kind kind);
  /// Identifies this host as far as shared memory reaches: the folder in which this runtime finds
  /// others is part of it.
  const std::string& host_identity();
  /// How this program introduces itself to an object of the interface `wanted`.
  Hello introduce(const InterfaceDescription& wanted) const;

  /// Closes `session` when this program exits, if it still lives.
  void close_at_exit(const std::shared_ptr<Closable>& session);
  /// Closes the sessions one after the other within `patience`, plus two heartbeats for each that
  /// does not answer, so that a stuck session takes no time from the others.
  void close_all(const std::vector<std::shared_ptr<Closable>>& sessions, Duration patience) const;
  /// Says goodbye in every open session.
  void close_sessions(Duration patience);

 private:
  const LabOptions options_;
  const Clock& clock_;
  Mutex mutex_;
  std::map<media::Kind, std::unique_ptr<media::Medium>> media_ GECOS_GUARDED_BY(mutex_);
  std::optional<std::string> host_identity_ GECOS_GUARDED_BY(mutex_);
  std::vector<std::weak_ptr<Closable>> sessions_ GECOS_GUARDED_BY(mutex_);
  Callbacks callbacks_;
  Maintenance maintenance_;  ///< last: its thread ends first
};

}  // namespace gecos::session
