// One laboratory of a client and a server, step by step, in an order that a seed gives.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/server/object_host.hpp"
#include "schedules/judge.hpp"
#include "schedules/line.hpp"

namespace gecos::session::schedules {

/// What the object offers: something of each lane, short and long.
const InterfaceDescription& bench();

/// Real sessions and a real object over a line of the test, one thread for all of theirs.
///
/// A step is what one thread of one process does until it sleeps: the client's program issues,
/// cancels, closes; its maintenance ticks; the server polls, maintains, begins what lies in a
/// lane or with a worker, finishes. The next is drawn. Between any two touches of what both
/// processes see (Line, the clock of pauses), too, one of them or both may stop for .05 to 10 s
/// while the other goes on, or end for good. Runs on the maintenance thread of `runtime`, which
/// so does nothing itself: its pause watch is the server's.
class Schedule {
 public:
  Schedule(std::shared_ptr<Runtime> runtime, ScheduleClock& clock, std::uint64_t seed,
           Mutant mutant);
  ~Schedule();
  Schedule(const Schedule&) = delete;
  Schedule& operator=(const Schedule&) = delete;

  /// What was wrong, a sentence each.
  std::vector<std::string> run();
  std::size_t begun_in_vain() const { return judge_.begun_in_vain(); }
  std::size_t commands() const { return judge_.count(); }
  int freezes() const { return freezes_; }

 private:
  class Handlers;
  enum class Lanes : std::uint8_t { Called, Queued };  ///< as C++ and Python servants do

  void open();
  void take_status();

  // Steps.
  void step(Side side);
  void client_step();
  void client_ticks();
  void issue();
  void server_step();
  void server_polls();
  void server_maintains();
  void server_begins();
  void server_works();
  void server_finishes();
  void part();

  // Time, and who stands still in it.
  void tick() { clock_.advance(Duration(1)); }
  bool runs(Side side) const { return !line_.dead(side); }
  void pass(Duration most);
  void touched(Side by);
  void freeze(Side side);
  void freeze_both();
  void wake(Side side, Duration stood_still);
  void cut();
  void kill(Side side);
  void look();
  void settle();

  void began(const IncomingCall& call);

  const std::shared_ptr<Runtime> runtime_;
  ScheduleClock& clock_;
  const Mutant mutant_;
  Dice dice_;
  const Lanes lanes_;
  Line line_;
  const Trace trace_;
  Judge judge_;
  PauseWatch& pauses_;
  std::unique_ptr<Handlers> handlers_;
  std::shared_ptr<ObjectHost> object_;
  std::shared_ptr<ServerSession> served_;
  std::shared_ptr<ClientConnection> session_;
  TimePoint client_due_{};
  TimePoint server_due_{};
  TimePoint server_beat_due_{};
  /// When the clock was read, by what it said: a server that cannot know that it stood still reads
  /// less.
  std::map<TimePoint, TimePoint> readings_;
  Side acts_ = Side::Server;  ///< takes the step
  int freezes_ = 0;
  bool closes_ = false;  ///< the client has said goodbye, or tried to
  bool inside_ = false;  ///< somebody else goes on within a step
  bool calm_ = true;     ///< nothing stops any more, or yet
};

}  // namespace gecos::session::schedules
