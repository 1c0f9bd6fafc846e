#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

class ClientConnection;
class Failover;

/// A lab as its servers and clients share it: what they stand on, and the session with the broker,
/// which ends with it. Thread-safe.
class Context : public std::enable_shared_from_this<Context> {
 public:
  explicit Context(std::shared_ptr<Runtime> runtime);
  ~Context();

  const std::shared_ptr<Runtime>& runtime() const { return runtime_; }
  const std::shared_ptr<Failover>& failover() const { return failover_; }
  /// The session with this lab's broker, opened when there is none; else what was tried.
  tl::expected<std::shared_ptr<ClientConnection>, std::string> broker(TimePoint deadline);

  /// `session` belongs to a proxy: it ends with `close`. False once that was called.
  bool keep(const std::shared_ptr<ClientConnection>& session);
  bool closed() const;
  /// Says goodbye in every session that is kept, for which it takes at most about `patience`; what
  /// waits in them ends. No more are kept. Servers go on, and so does the session with the broker.
  void close(Duration patience);

 private:
  /// Where a broker may be. Adds to `tried` why a medium that leads to one cannot be had here.
  std::vector<std::string> broker_addresses(std::string& tried);
  tl::expected<std::shared_ptr<ClientConnection>, std::string> look_for_broker(TimePoint deadline);
  void note_broker(std::shared_ptr<ClientConnection> found, std::string missing);

  const std::shared_ptr<Runtime> runtime_;
  const std::shared_ptr<Failover> failover_;
  std::mutex mutex_;  ///< guards what follows
  std::condition_variable looked_;
  bool looking_ = false;  ///< one thread at a time looks for the broker
  std::shared_ptr<ClientConnection> broker_;
  std::string missing_;  ///< why there was none when one was looked for last

  mutable std::mutex keeping_;  ///< guards what follows
  std::vector<std::weak_ptr<ClientConnection>> kept_;
  bool closed_ = false;
};

/// A session with the object of that name, or why there is none.
tl::expected<std::shared_ptr<ClientConnection>, CreateError::Attempt> open_object(
    Context& lab, const InterfaceDescription& wanted, const std::string& name,
    const CreateOptions& options);

}  // namespace gecos::session
