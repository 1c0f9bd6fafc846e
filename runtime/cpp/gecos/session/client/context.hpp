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
  /// The session with this lab's broker, opened when there is none. Fails with what was tried.
  tl::expected<std::shared_ptr<ClientConnection>, std::string> broker(TimePoint deadline);

  /// Keeps `session`, which belongs to a proxy, to be ended by `close`. Returns false after `close`
  /// was called.
  bool keep(const std::shared_ptr<ClientConnection>& session);
  bool closed() const;
  /// Says goodbye in every kept session, within about `patience`; commands that wait in them end.
  /// No more sessions are kept. Servers continue, and so does the session with the broker.
  void close(Duration patience);

 private:
  /// The addresses at which a broker may be. Adds to `tried` why a medium that leads to one is not
  /// available here.
  std::vector<std::string> broker_addresses(std::string& tried);
  tl::expected<std::shared_ptr<ClientConnection>, std::string> look_for_broker(TimePoint deadline);
  /// True when there is a session with a broker that is not lost.
  bool knows_broker() const GECOS_REQUIRES(mutex_);
  void note_broker(std::shared_ptr<ClientConnection> found, std::string missing);

  const std::shared_ptr<Runtime> runtime_;
  const std::shared_ptr<Failover> failover_;
  Mutex mutex_;
  ConditionVariable looked_;
  /// One thread at a time looks for the broker.
  bool looking_ GECOS_GUARDED_BY(mutex_) = false;
  std::shared_ptr<ClientConnection> broker_ GECOS_GUARDED_BY(mutex_);
  /// Why the last search found no broker.
  std::string missing_ GECOS_GUARDED_BY(mutex_);

  mutable Mutex keeping_;
  std::vector<std::weak_ptr<ClientConnection>> kept_ GECOS_GUARDED_BY(keeping_);
  bool closed_ GECOS_GUARDED_BY(keeping_) = false;
};

/// A session with the object of that name, or why there is none.
tl::expected<std::shared_ptr<ClientConnection>, CreateError::Attempt> open_object(
    Context& lab, const InterfaceDescription& wanted, const std::string& name,
    const CreateOptions& options);

}  // namespace gecos::session
