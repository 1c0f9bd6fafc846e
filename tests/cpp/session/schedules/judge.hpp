// What a schedule knows of each command, and what is wrong with it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gecos/session/client/pending_command.hpp"
#include "schedules/line.hpp"

namespace gecos::session::schedules {

/// Counts what becomes of the commands of one client. All times are of the schedule's clock, which
/// differs at any two events.
class Judge {
 public:
  /// Before it is sent. Gives the number by which the handler tells which command it has.
  std::size_t issued(const OperationDescription& operation, TimePoint now, Duration deadline);
  void sent(std::size_t number, std::shared_ptr<PendingCommand> command) {
    commands_[number].core = std::move(command);
  }
  /// Notes which have ended. To be called after each step of their client.
  void look(TimePoint now);
  /// The server's start of it was marked at `marked`; the freeze in which it did not begin, if any,
  /// has that number.
  void began(std::size_t number, TimePoint marked, TimePoint now, int freeze);
  void finished(std::size_t number) { commands_[number].finished = true; }
  /// The client's process ended; its commands need no end.
  void client_died(TimePoint now) { died_ = now; }
  /// The client was told that its goodbye has arrived: what the server has may go on.
  void drains() { drains_ = true; }
  /// The server took its goodbye, while it knew nothing of a pause: nobody need live any more.
  void parted() { parted_ = true; }
  /// The client stood still, perhaps between what it reckoned of a deadline and its sending.
  void client_stood_still(Duration length);
  /// Nothing tells the server at once: it may take so long until it knows what was withdrawn.
  void news_take(Duration longest) { news_take_ = longest; }
  /// The server stood still until `now` for long enough to know it.
  void server_woke(TimePoint now) { woke_ = now; }

  bool all_ended() const;
  std::size_t count() const { return commands_.size(); }
  PendingCommand& command(std::size_t number) { return *commands_[number].core; }
  /// At the end of the schedule.
  void sum_up();
  const std::vector<std::string>& alarms() const { return alarms_; }
  /// Handlers that began after OUTCOME_UNKNOWN or SERVER_CRASHED, for a freeze after their mark.
  std::size_t begun_in_vain() const { return begun_in_vain_; }

 private:
  struct Entry {
    std::shared_ptr<PendingCommand> core;
    const OperationDescription* operation = nullptr;
    TimePoint deadline = TimePoint::max();
    std::optional<TimePoint> ended;
    Detail end = Detail::Sent;
    int begun = 0;
    bool finished = false;
  };
  std::size_t running_beside() const;
  void alarm(std::size_t number, const std::string& what);

  const Trace trace_;
  std::vector<Entry> commands_;
  std::map<int, int> vain_by_freeze_;
  std::map<int, std::size_t> vain_beside_others_;  ///< likewise, of @parallel commands
  std::size_t begun_in_vain_ = 0;
  std::optional<TimePoint> died_;
  std::optional<TimePoint> woke_;
  Duration news_take_{};
  bool drains_ = false;
  bool parted_ = false;
  std::vector<std::string> alarms_;
};

}  // namespace gecos::session::schedules
