#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/broker/directory.hpp"
#include "gecos/broker/kept_names.hpp"
#include "gecos/broker/processes.hpp"
#include "gecos/broker/view.hpp"
#include "gecos/broker/visitor_lists.hpp"
#include "gecos/broker_server.hpp"
#include "gecos/serve.hpp"
#include "gecos/server.hpp"

namespace gecos::broker {

struct BrokerOptions {
  /// The time for which a silent server of another host keeps its names.
  Duration name_hold = DirectoryOptions().name_hold;
};

/// The broker as an object: `gecos::serve(lab, {broker.serving()})` serves it at this host's
/// well-known address; `broker.serve(server)` serves the broker in a program that has a server of
/// its own. An object leaves the broker's list when the session that registered the object ends. If
/// the server of the object runs on this host, the object also leaves the list when the kernel
/// reports the end of the server's process (directory.hpp). In its first second the broker prefers
/// objects that were served before the broker started. A broker that is served over shm knows which
/// objects of this host's processes were registered with the previous broker (kept_names.hpp).
class Broker final : public BrokerServant {
 public:
  explicit Broker(const BrokerOptions& options = {});
  ~Broker() override;

  /// Returns the broker as an object for `gecos::serve`. The first second of the broker begins with
  /// this call. Throws std::system_error when the process has no thread or descriptor left.
  Serving serving(std::vector<media::Kind> media = {});
  /// Serves this broker. Fails when this host has a broker already, and when the process has no
  /// thread or descriptor left.
  tl::expected<void, ServeError> serve(Server& server, std::vector<media::Kind> media = {});

  void gecos_dispatch(IncomingCall call) override;
  void gecos_session_ended(std::uint64_t session) override;

 protected:
  Result<std::optional<double>> enlist(const Entry& told, double served_for,
                                       const std::optional<AdmittedNames>& admitted,
                                       const std::optional<double>& confirmed_ago) override;
  Result<void> withdraw(const std::string& name) override;
  Result<Entry> lookup(const std::string& name) override;
  Result<std::vector<Entry>> list() override;
  Result<std::vector<SilentObject>> silent() override;
  Result<std::vector<Entry>> query(const std::string& interface_name) override;
  Result<ListChanges> changes(const ListRevision& since) override;
  Result<ListRevision> revision() override;
  Result<void> free(const std::string& name) override;
  Result<RevocationList> revocations(std::uint64_t applied) override;
  Result<RevocationState> behind(const std::vector<Revocation>& revoked) override;

 private:
  Directory new_directory(Duration young) const;
  /// Reads which objects of this host were registered with the previous broker. Does so only if
  /// `media`, over which this broker is served, include shm; empty means all media.
  void expect_known(const std::vector<media::Kind>& media) GECOS_REQUIRES(mutex_);
  void start_threads();
  void watch_processes();
  /// For each EndedSession whose time `due` has come, marks the objects of its server as silent.
  /// Returns the time until the next EndedSession is due.
  Duration end_due_sessions(TimePoint now) GECOS_REQUIRES(mutex_);
  void end_session(std::uint64_t session, TimePoint heard) GECOS_REQUIRES(mutex_);
  /// Removes the objects of processes that have ended. Each operation calls this first, because the
  /// kernel may report an end before `watcher_` runs.
  void remove_ended() GECOS_REQUIRES(mutex_);
  void forget_unused_processes() GECOS_REQUIRES(mutex_);
  /// Publishes the number of the list, and writes down the names that the next broker keeps, if
  /// they may have changed.
  void announce() GECOS_REQUIRES(mutex_);
  /// Returns the part of the directory that the client of the current call may see.
  View view() const GECOS_REQUIRES(mutex_);

  const BrokerOptions options_;
  struct {
    std::uint64_t session = 0;
    std::uint64_t incarnation = 0;
    std::shared_ptr<const session::CallCore> call;
  } calling_;    ///< the client of the current call; handlers run one at a time
  Mutex mutex_;  ///< needed because calls run on one thread and sessions end on another
  Directory directory_ GECOS_GUARDED_BY(mutex_);
  struct {
    std::uint64_t number = 0;  ///< the number of the last published change
    bool settled = false;      ///< see `Directory::has_settled`
  } announced_ GECOS_GUARDED_BY(mutex_);
  std::optional<Processes> processes_ GECOS_GUARDED_BY(mutex_);  ///< set while the broker is served
  /// Set while the broker is served over shm.
  std::optional<KeptNames> kept_ GECOS_GUARDED_BY(mutex_);
  /// A session of a server on this host that has ended. The session may have ended because the
  /// process died: the kernel closes the sockets of a process before it reports the end of the
  /// process. Until `due`, the broker waits for this report. Then it lists the objects of the
  /// server as silent.
  struct EndedSession {
    std::uint64_t session = 0;
    TimePoint heard;
    TimePoint due;
  };
  std::vector<EndedSession> ended_sessions_ GECOS_GUARDED_BY(mutex_);
  VisitorLists visitor_lists_;  ///< started while the broker is served
  /// For each session, the number of the list of revocations that the server of the session has
  /// applied.
  std::map<std::uint64_t, std::uint64_t> applied_ GECOS_GUARDED_BY(mutex_);
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
  std::optional<EventFd> wake_watcher_;  ///< set while the broker is served
  std::thread watcher_;
};

}  // namespace gecos::broker
