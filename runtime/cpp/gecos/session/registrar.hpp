#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/lab_core.hpp"

namespace gecos::session {

class ServedObject;

/// Keeps the objects of a server findable: enlists them with the broker, and again with every
/// broker that comes up after the one before was lost.
class Registrar {
 public:
  explicit Registrar(std::shared_ptr<LabCore> lab);
  ~Registrar() { end(); }

  /// Waits until a broker answers, for it may be about to start; else says what was tried.
  tl::expected<void, std::string> await_broker(TimePoint deadline);
  /// Enlists it; findable when this returns. Fails when no broker answers or the name is taken.
  tl::expected<void, std::string> add(const ServedObject& object,
                                      std::vector<std::string> addresses);
  /// Sees to it that a lost broker is looked for. Never blocks.
  void look();
  /// Withdraws all.
  void end();

 private:
  void run();
  tl::expected<std::shared_ptr<LinkedSession>, std::string> enlist_first(const Entry& entry,
                                                                         TimePoint deadline);
  bool enlist_again();
  /// Tells the user once why there is none when that lasts; empty when there is one.
  void note_broker(const std::string& missing);
  /// Of this host, for of others it cannot be told. Whoever has no pid here counts as ended too.
  bool holder_has_ended(const std::string& name, TimePoint deadline) const;
  /// False when it is over: the deadline has come, or the end.
  bool rest(Duration length, TimePoint deadline);

  const std::shared_ptr<LabCore> lab_;
  std::mutex mutex_;
  std::condition_variable changed_;  ///< of our thread and of all that rest: always told to all
  std::vector<Entry> entries_;
  std::shared_ptr<LinkedSession> broker_;  ///< where they are enlisted
  std::optional<TimePoint> missing_since_;
  bool told_missing_ = false;
  std::string told_;  ///< why some are not findable; of our thread
  bool wanted_ = false;
  bool ended_ = false;
  std::thread thread_;  ///< looking for a broker blocks, so it has a thread of its own
};

}  // namespace gecos::session
