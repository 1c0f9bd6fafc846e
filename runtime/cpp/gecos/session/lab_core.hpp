#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/session/handshake.hpp"
#include "gecos/session/housekeeping.hpp"
#include "gecos/session/lab.hpp"

namespace gecos::session {

class LinkedSession;

/// This life of this process.
BootId process_boot();

/// What a lab's sessions and servers share: settings, the clock, the media, the housekeeping thread
/// and the session with the broker. Thread-safe.
class LabCore : public std::enable_shared_from_this<LabCore> {
 public:
  LabCore(LabOptions options, const Clock& clock);
  ~LabCore();

  const LabOptions& options() const { return options_; }
  const Clock& clock() const { return clock_; }
  Housekeeping& housekeeping() { return housekeeping_; }

  /// The medium of this kind, opened at first use, or why it cannot be had here.
  tl::expected<media::Medium*, media::MediumError> medium(media::Kind kind);
  /// Which host this is, as far as shared memory reaches; empty where it cannot be used.
  const std::string& host_identity();
  /// What this program says of itself to `interface_name`.
  Hello introduce(const InterfaceDescription& wanted) const;

  /// Connects to `address` ("shm:…") and opens a session for `wanted`.
  tl::expected<std::shared_ptr<LinkedSession>, std::string> connect(
      const std::string& address, const InterfaceDescription& wanted, TimePoint deadline,
      Detail* why = nullptr);

  /// The session with this lab's broker, opened when there is none; else what was tried.
  tl::expected<std::shared_ptr<LinkedSession>, std::string> broker(TimePoint deadline);

  /// Says goodbye in every open session: a program ends.
  void close_sessions(Duration patience);

 private:
  std::vector<std::string> broker_addresses();

  const LabOptions options_;
  const Clock& clock_;
  std::mutex mutex_;
  std::map<media::Kind, tl::expected<std::unique_ptr<media::Medium>, media::MediumError>> media_;
  std::vector<std::weak_ptr<LinkedSession>> sessions_;
  std::mutex broker_mutex_;  ///< one thread at a time looks for the broker
  std::shared_ptr<LinkedSession> broker_;
  Housekeeping housekeeping_;  ///< last: its thread ends first
};

/// A core that says goodbye for its sessions when the program exits, however the lab is dropped.
std::shared_ptr<LabCore> make_lab_core(LabOptions options, const Clock& clock);

}  // namespace gecos::session
