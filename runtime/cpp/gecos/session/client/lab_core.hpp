#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

class LinkedSession;
class Renewal;

/// A lab as its servers and clients share it: what they stand on, and the session with the broker,
/// which ends with it. Thread-safe.
class LabCore : public std::enable_shared_from_this<LabCore> {
 public:
  explicit LabCore(std::shared_ptr<Runtime> runtime);
  ~LabCore();

  const std::shared_ptr<Runtime>& runtime() const { return runtime_; }
  const std::shared_ptr<Renewal>& renewal() const { return renewal_; }
  /// The session with this lab's broker, opened when there is none; else what was tried.
  tl::expected<std::shared_ptr<LinkedSession>, std::string> broker(TimePoint deadline);

  /// `session` belongs to a proxy: it ends with `close`. False once that was called.
  bool keep(const std::shared_ptr<LinkedSession>& session);
  bool closed() const;
  /// Says goodbye in every session that is kept, for which it takes at most about `patience`; what
  /// waits in them ends. No more are kept. Servers go on, and so does the session with the broker.
  void close(Duration patience);

 private:
  /// Where a broker may be. Adds to `tried` why a medium that leads to one cannot be had here.
  std::vector<std::string> broker_addresses(std::string& tried);
  tl::expected<std::shared_ptr<LinkedSession>, std::string> look_for_broker(TimePoint deadline);
  void note_broker(std::shared_ptr<LinkedSession> found, std::string missing);

  const std::shared_ptr<Runtime> runtime_;
  const std::shared_ptr<Renewal> renewal_;
  std::mutex mutex_;  ///< guards what follows
  std::condition_variable looked_;
  bool looking_ = false;  ///< one thread at a time looks for the broker
  std::shared_ptr<LinkedSession> broker_;
  std::string missing_;  ///< why there was none when one was looked for last

  mutable std::mutex keeping_;  ///< guards what follows
  std::vector<std::weak_ptr<LinkedSession>> kept_;
  bool closed_ = false;
};

/// A session with the object of that name, or why there is none.
tl::expected<std::shared_ptr<LinkedSession>, CreateError::Attempt> open_object(
    LabCore& lab, const InterfaceDescription& wanted, const std::string& name,
    const CreateOptions& options);

}  // namespace gecos::session
