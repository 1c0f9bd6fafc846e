#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/broker_client.hpp"
#include "gecos/session/client/context.hpp"
#include "gecos/session/server/access_control.hpp"
#include "gecos/session/server/ask_pause.hpp"
#include "gecos/session/server/broker_contact.hpp"

namespace gecos::session {

class ObjectHost;

/// Keeps the objects of a server registered with the broker, so that clients find them. When the
/// broker was lost, registers the objects again with each broker that starts at the same address.
/// Reports to each object whether the broker confirms its name, and asks the broker again after a
/// pause of this process.
class Registrar {
 public:
  /// `access` knows which users this server admits, and the broker is told of these users.
  Registrar(std::shared_ptr<Context> lab, std::shared_ptr<BrokerContact> contact,
            std::shared_ptr<AccessControl> access);
  ~Registrar() { end(); }

  /// Waits until a broker answers, because the broker may still be starting. On failure returns a
  /// text with the addresses that were tried, and for each address the reason of the failure.
  tl::expected<void, std::string> await_broker(TimePoint deadline);
  /// Registers `object`. Clients can find the object when this function has returned. Fails when no
  /// broker answers or the name is taken.
  tl::expected<void, std::string> add(const std::shared_ptr<ObjectHost>& object,
                                      std::vector<std::string> addresses);
  /// If it is time, asks the broker which users the laboratory has revoked. If the broker was lost,
  /// or may have ended, starts the search for a new broker. Never blocks.
  void look();
  /// Must be called when the list of the program or the lab file has changed. If an object now
  /// admits other users than before, the broker is told soon.
  void renew_lists();
  /// Called after a pause of this process. Makes the thread of the registrar ask the broker again
  /// whether it confirms the names of all objects. If the pause was longer than a registration
  /// lives, other servers may have got the names: the objects count as served from now on.
  void after_pause(Duration stood_still);
  /// Unregisters all objects.
  void end();

 private:
  struct Registration {
    Entry entry;
    std::shared_ptr<ObjectHost> object;
    /// Since when the object is served under its name, by CLOCK_BOOTTIME: since its first
    /// registration, unless the name was taken later, or may have been.
    TimePoint since{};
    /// When the last question was sent to which a broker gave a final answer, by CLOCK_BOOTTIME.
    /// Whoever has the name later is confirmed later.
    std::optional<TimePoint> confirmed{};
    AdmittedNames admitted{};  ///< sent to the broker with each registration
  };
  using Broker = std::shared_ptr<ClientConnection>;
  /// What `thread_` must do. A later value includes the earlier ones.
  enum class Work : std::uint8_t {
    None,
    LookForNewBroker,  ///< the broker is silent: if another one has its place, ask that one
    Ask,               ///< ask the broker whether it confirms the names
  };

  void run();
  /// Looks for a broker that has taken the place of a silent one. Returns whether it has found one.
  bool has_new_broker();
  struct Answers {
    TimePoint asked;  ///< when the questions were sent, by CLOCK_BOOTTIME
    std::vector<tl::expected<Duration, NotRegistered>> of_each;
    std::string missing;  ///< why no broker was found
    BrokerAnswer broker = BrokerAnswer::Other;
    bool lost = false;  ///< the session with the broker was lost during the query, or the broker
                        ///< may have ended
  };
  /// Asks the broker whether it confirms the names, and passes the answers to the objects. Returns
  /// how long to wait before the broker is asked again; Duration::max() when the answers for all
  /// names are final.
  Duration ask(const std::vector<Registration>& registrations);
  Answers ask_broker(const std::vector<Registration>& registrations, TimePoint deadline);
  /// Updates the list of the users and hosts that the object admits, with at most as many names as
  /// the broker accepts. If the list has changed, gives it a new number and returns true.
  bool renew(Registration& registration) const GECOS_REQUIRES(mutex_);
  tl::expected<Broker, NoBroker> find_broker(TimePoint deadline);
  void want(Work work) GECOS_REQUIRES(mutex_);
  /// Notes that another server has got the name. If a broker starts later that knows neither, this
  /// object must not take the name back because it was served earlier.
  void note_loss(const std::string& name);
  void note_confirmed(const std::string& name, TimePoint asked);
  struct Registered {
    Duration provisional;  ///< 0: the answer is final
    Broker by;
  };
  tl::expected<Registered, std::string> register_first(Registration& registration,
                                                       TimePoint deadline);
  void take_back(ClientConnection& broker, const std::string& name);
  /// Logs a warning, once, if the broker runs as another user, this server admits other users by
  /// the list of its program, and these users cannot reach this server over shm.
  void note_reach(const Registration& registration) GECOS_REQUIRES(mutex_);
  /// Logs a warning, once, when no broker has answered for a while. `missing`: why no broker
  /// answers; empty when a broker answers.
  void note_broker(const std::string& missing);
  /// Returns whether `name`, which another object has, may become free before the deadline. This is
  /// so if the server process of that object has ended on this host, if the object has just left
  /// the list, or if its server is silent and loses the name in time.
  bool becomes_free(const std::string& name, TimePoint deadline) const;
  /// Sleeps for `length`. Returns false when the deadline has passed or `end` was called.
  bool rest(Duration length, TimePoint deadline);

  const std::shared_ptr<Context> lab_;
  const std::shared_ptr<BrokerContact> contact_;
  const std::shared_ptr<AccessControl> access_;
  Mutex mutex_;
  /// `thread_` and `rest` wait on this variable, so it must be notified with notify_all only.
  ConditionVariable changed_;
  std::vector<Registration> registrations_ GECOS_GUARDED_BY(mutex_);
  Broker broker_ GECOS_GUARDED_BY(mutex_);  ///< the broker with which the objects are registered
  /// The address of the first broker; later brokers are expected at the same address.
  std::string place_ GECOS_GUARDED_BY(mutex_);
  std::optional<TimePoint> missing_since_ GECOS_GUARDED_BY(mutex_);
  bool noted_reach_ GECOS_GUARDED_BY(mutex_) = false;
  bool reported_missing_ GECOS_GUARDED_BY(mutex_) = false;
  // Only `thread_` uses `reported_` and `pause_`.

  /// The last logged warning that clients cannot find some objects, without the request number of
  /// each refusal.
  std::string reported_;
  AskPause pause_;
  Work wanted_ GECOS_GUARDED_BY(mutex_) = Work::None;
  /// The time at which `thread_` asks the broker again; TimePoint::max(): only when `wanted_` says
  /// so.
  TimePoint next_ GECOS_GUARDED_BY(mutex_) = TimePoint::max();
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
  std::thread thread_;  ///< own thread, because the search for a broker blocks
};

}  // namespace gecos::session
