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

/// What sessions and servers of one lab stand on: settings, the clock, the media and the
/// maintenance thread. It lives as long as the last of them. Thread-safe.
class Runtime : public std::enable_shared_from_this<Runtime> {
 public:
  /// When the program exits, however its labs are dropped, its sessions say goodbye.
  /// Fails when this process has no thread or descriptor left for it.
  static tl::expected<std::shared_ptr<Runtime>, NoLab> make(LabOptions options, const Clock& clock);

  Runtime(LabOptions options, const Clock& clock);
  ~Runtime();

  const LabOptions& options() const { return options_; }
  const Clock& clock() const { return clock_; }
  Maintenance& maintenance() { return maintenance_; }
  Callbacks& callbacks() { return callbacks_; }
  /// Silence after which a session ends, and with it what a server enlisted with a broker.
  Duration registration_ttl() const { return options_.lease_ttl + options_.grace; }

  /// The medium of this kind, opened at first use, or why it cannot be had here now.
  tl::expected<media::Medium*, media::MediumError> medium(media::Kind kind);
  /// Which host this is, as far as shared memory reaches: the folder that this runtime meets
  /// others in is part of it.
  const std::string& host_identity();
  /// What this program says of itself to `interface_name`.
  Hello introduce(const InterfaceDescription& wanted) const;

  /// It is closed when this program exits, should it still live.
  void close_at_exit(const std::shared_ptr<Closable>& session);
  /// Closes one after the other within `patience`, and two heartbeats more for each that does not
  /// answer: who is stuck takes no other's share.
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
