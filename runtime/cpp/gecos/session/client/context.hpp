#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

class ClientConnection;
class Failover;

/// The part of a lab that its servers and clients share: the runtime, and the session with the
/// broker, which ends with the lab. Thread-safe.
class Context : public std::enable_shared_from_this<Context> {
 public:
  explicit Context(std::shared_ptr<Runtime> runtime);
  ~Context();

  const std::shared_ptr<Runtime>& runtime() const { return runtime_; }
  const std::shared_ptr<Failover>& failover() const { return failover_; }
  /// The session with this lab's broker; opens it when there is none. Fails with the addresses that
  /// were tried and why they failed.
  tl::expected<std::shared_ptr<ClientConnection>, std::string> broker(TimePoint deadline);

  /// Notes `session`, which belongs to a proxy, so that `close` ends it. Returns false after
  /// `close` was called.
  bool keep(const std::shared_ptr<ClientConnection>& session);
  bool closed() const;
  /// Waits until the lab is closed, or until `deadline`. Returns whether it is closed.
  bool closed_by(TimePoint deadline);
  /// Says goodbye in every kept session, within about `patience`; commands that wait in these
  /// sessions end. After it, no session is kept. Servers and the session with the broker continue.
  void close(Duration patience);

 private:
  /// The addresses at which a broker may be. Adds to `tried` why a medium that leads to a broker is
  /// not available here.
  std::vector<std::string> broker_addresses(std::string& tried);
  tl::expected<std::shared_ptr<ClientConnection>, std::string> look_for_broker(TimePoint deadline);
  /// True when there is a session with a broker and the session is not lost.
  bool knows_broker() const GECOS_REQUIRES(mutex_);
  void note_broker(std::shared_ptr<ClientConnection> found, std::string missing);

  const std::shared_ptr<Runtime> runtime_;
  const std::shared_ptr<Failover> failover_;
  Mutex mutex_;
  ConditionVariable looked_;
  /// A thread is looking for the broker; only one thread at a time may do so.
  bool looking_ GECOS_GUARDED_BY(mutex_) = false;
  std::shared_ptr<ClientConnection> broker_ GECOS_GUARDED_BY(mutex_);
  /// Why the last search found no broker.
  std::string missing_ GECOS_GUARDED_BY(mutex_);

  mutable Mutex keeping_;
  std::vector<std::weak_ptr<ClientConnection>> kept_ GECOS_GUARDED_BY(keeping_);
  ConditionVariable closing_;
  bool closed_ GECOS_GUARDED_BY(keeping_) = false;
};

/// Opens a session with the object `name`, or returns why it failed.
tl::expected<std::shared_ptr<ClientConnection>, CreateError::Attempt> open_object(
    Context& lab, const InterfaceDescription& wanted, const std::string& name,
    const CreateOptions& options);

}  // namespace gecos::session
