#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/lab_file_settings.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/broker_answer.hpp"

namespace gecos::session {

class ClientConnection;
class Failover;

/// Says why there is no session with a broker.
struct NoBroker {
  std::string text;  ///< the addresses that were tried, and why each failed
  BrokerAnswer answer = BrokerAnswer::Other;
};

/// The part of a lab that its servers and clients share: the runtime, and the session with the
/// broker. That session ends when this object is destroyed. Thread-safe.
class Context : public std::enable_shared_from_this<Context> {
 public:
  explicit Context(std::shared_ptr<Runtime> runtime);
  ~Context();

  const std::shared_ptr<Runtime>& runtime() const { return runtime_; }
  const std::shared_ptr<Failover>& failover() const { return failover_; }
  /// Returns the session with this lab's broker, and opens it when there is none. If the broker may
  /// have ended (ClientConnection::may_have_ended), looks whether another broker has started at its
  /// address; if none answers, or another thread is looking, returns the session with the silent
  /// broker.
  tl::expected<std::shared_ptr<ClientConnection>, NoBroker> broker(TimePoint deadline);

  /// Returns what the lab file states about the media. On failure, returns why the file cannot be
  /// used.
  StatedMedia lab_media(TimePoint deadline) { return lab_file_.media(deadline); }

  /// Records `session`, the session of a proxy, so that `close` can end it. Returns false when
  /// `close` was called before.
  bool keep(const std::shared_ptr<ClientConnection>& session);
  bool closed() const;
  /// Waits until the lab is closed, or until `deadline`. Returns whether it is closed.
  bool closed_by(TimePoint deadline);
  /// Closes every session that `keep` recorded, within about `patience`, and ends the commands in
  /// them. Later calls of `keep` record nothing. Servers and the session with the broker continue.
  void close(Duration patience);

 private:
  /// Returns the address of the broker: the address that the program gives, else the address in
  /// GECOS_BROKER, else the address in the lab file. Fails if the lab file is needed and cannot be
  /// used, because the lab file may name a broker other than that of this host.
  tl::expected<access::LabBroker, std::string> named_broker(TimePoint deadline);
  /// Returns the addresses at which the broker `named` may answer. If a medium is not available to
  /// this program, adds the reason to `tried`.
  std::vector<std::string> broker_addresses(const access::LabBroker& named, std::string& tried);
  tl::expected<std::shared_ptr<ClientConnection>, NoBroker> look_for_broker(TimePoint deadline);
  /// Returns the session with the broker that has taken the place of the broker of `silent`, and
  /// ends `silent`. Returns `silent` if no such broker answers.
  std::shared_ptr<ClientConnection> successor_of(std::shared_ptr<ClientConnection> silent,
                                                 TimePoint deadline);
  /// Returns true when this lab has a session with a broker and the session is not lost.
  bool knows_broker() const GECOS_REQUIRES(mutex_);
  void note_broker(std::shared_ptr<ClientConnection> found, std::string missing);

  const std::shared_ptr<Runtime> runtime_;
  const std::shared_ptr<Failover> failover_;
  LabFileSettings lab_file_;
  Mutex mutex_;
  ConditionVariable looked_;
  /// True while a thread searches for the broker. Only one thread at a time may search.
  bool looking_ GECOS_GUARDED_BY(mutex_) = false;
  std::shared_ptr<ClientConnection> broker_ GECOS_GUARDED_BY(mutex_);
  /// The reason why the last search found no broker.
  std::string missing_ GECOS_GUARDED_BY(mutex_);

  mutable Mutex keeping_;
  std::vector<std::weak_ptr<ClientConnection>> kept_ GECOS_GUARDED_BY(keeping_);
  ConditionVariable closing_;
  bool closed_ GECOS_GUARDED_BY(keeping_) = false;
};

/// Returns the failure of an attempt to open a session with `name` after the lab was closed.
CreateError::Attempt closed_lab(const std::string& name);

/// Returns the broker's entry of the object `name`, which must have the interface `wanted`. On
/// failure, returns why the object cannot be used.
tl::expected<Entry, CreateError::Attempt> find_entry(Context& lab,
                                                     const InterfaceDescription& wanted,
                                                     const std::string& name,
                                                     const CreateOptions& options);

/// Returns what the lab file states about the media that lead to `entry`. Reads the file only if
/// `wanted` or `requested` demands HARD_REALTIME of them; otherwise, returns no statement.
StatedMedia stated_media(Context& lab, const InterfaceDescription& wanted, const Entry& entry,
                         TimePoint deadline, const qos::RequestedQuality& requested = {});

/// Opens a session with the object `name`, or returns why it failed.
tl::expected<std::shared_ptr<ClientConnection>, CreateError::Attempt> open_object(
    Context& lab, const InterfaceDescription& wanted, const std::string& name,
    const CreateOptions& options);

/// Opens a second session with the object and the server process that the session `slow` uses, over
/// the best medium other than the medium of `slow`. The latency that is measured over this medium
/// must not exceed the bound that applies to `slow`. On failure returns why no such session could
/// be opened.
tl::expected<std::shared_ptr<ClientConnection>, CreateError::Attempt> open_elsewhere(
    Context& lab, ClientConnection& slow);

}  // namespace gecos::session
