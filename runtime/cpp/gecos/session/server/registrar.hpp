#pragma once

#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/broker_client.hpp"
#include "gecos/session/client/context.hpp"

namespace gecos::session {

class ObjectHost;

/// Keeps the objects of a server findable: enlists them with the broker, and again with every
/// broker that comes up at the same place after the one before was lost. Tells each object how its
/// claim to its name stands; after a pause of this process it asks anew.
class Registrar {
 public:
  explicit Registrar(std::shared_ptr<Context> lab);
  ~Registrar() { end(); }

  /// Waits until a broker answers, for it may be about to start; else says what was tried.
  tl::expected<void, std::string> await_broker(TimePoint deadline);
  /// Enlists it; findable when this returns. Fails when no broker answers or the name is taken.
  tl::expected<void, std::string> add(const std::shared_ptr<ObjectHost>& object,
                                      std::vector<std::string> addresses);
  /// Sees to it that a lost broker is looked for. Never blocks.
  void look();
  /// The objects have new questions about their names.
  void ask_again();
  /// Withdraws all.
  void end();

 private:
  struct Registration {
    Entry entry;
    std::shared_ptr<ObjectHost> object;
    TimePoint since{};  ///< when it was enlisted first, by CLOCK_BOOTTIME
  };
  using Broker = std::shared_ptr<ClientConnection>;

  void run();
  struct Answers {
    std::vector<tl::expected<Duration, NotRegistered>> of_each;
    std::string missing;  ///< why there is no broker
    bool lost = false;    ///< the session in which it was asked
  };
  /// Tells the objects what the broker says. Gives how long to wait before it is asked again; for
  /// ever when every name is settled.
  Duration ask(const std::vector<Registration>& registrations);
  Answers ask_broker(const std::vector<Registration>& registrations, TimePoint deadline);
  tl::expected<Broker, std::string> find_broker(TimePoint deadline);
  void ask_soon() GECOS_REQUIRES(mutex_);
  Duration served_for(const Registration& registration) const;
  tl::expected<Duration, std::string> register_first(Registration& registration,
                                                     TimePoint deadline);
  /// Tells the user once why there is none when that lasts; empty when there is one.
  void note_broker(const std::string& missing);
  /// Of this host, for of others it cannot be told. Whoever has no pid here counts as ended too.
  bool holder_has_ended(const std::string& name, TimePoint deadline) const;
  /// False when it is over: the deadline has come, or the end.
  bool rest(Duration length, TimePoint deadline);

  const std::shared_ptr<Context> lab_;
  Mutex mutex_;
  ConditionVariable changed_;  ///< of our thread and of all that rest: always told to all
  std::vector<Registration> registrations_ GECOS_GUARDED_BY(mutex_);
  Broker broker_ GECOS_GUARDED_BY(mutex_);  ///< where they are enlisted
  /// Of the first broker: its successors are found there.
  std::string place_ GECOS_GUARDED_BY(mutex_);
  std::optional<TimePoint> missing_since_ GECOS_GUARDED_BY(mutex_);
  bool reported_missing_ GECOS_GUARDED_BY(mutex_) = false;
  std::string reported_;  ///< why some are not findable; of our thread
  bool wanted_ GECOS_GUARDED_BY(mutex_) = false;
  TimePoint next_ GECOS_GUARDED_BY(mutex_) = TimePoint::max();  ///< when it is asked again
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
  std::thread thread_;  ///< looking for a broker blocks, so it has a thread of its own
};

}  // namespace gecos::session
