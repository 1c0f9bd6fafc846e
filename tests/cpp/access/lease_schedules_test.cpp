// 100,000 random schedules of a lease table: acquire, release, take over, give back, stop, break,
// silence and death, compared step by step with a model of its own. The model knows no epochs as
// numbers: it keeps for each session the set of moments at which a command must have been issued to
// start. A watcher that asks for the changes of the holders now and then must know the holders of
// the model after each answer. SCHEDULES and SCHEDULES_SEED ask for others.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>

#include "gecos/access/lease_table.hpp"
#include "gecos/access/roster_changes.hpp"

namespace gecos::access {
namespace {

using namespace std::chrono_literals;
using Commands = LeaseTable::Commands;

constexpr Duration ttl = 500ms;

/// What the model forgets, so that a test shows that the schedules find it.
enum class Mutant {
  None,
  FenceForgotten,
  TakerOutlivesDeath,
  TakerOutlivesGiveBack,
  AnyoneJoins,
  BreakSparesAHolder,
  ReleaseIsNotTold,
};

/// Era: the number of times that everything issued before was fenced for at least one session.
using Era = int;

struct Share {
  Status status = Status::Actor;
  std::string password;
  TimePoint expires{};
  int claims = 1;
  bool releasing = false;
};

class Model {
 public:
  explicit Model(Mutant mutant) : mutant_(mutant) {}

  bool acquire(SessionId who, Status wanted, const std::string& password, TimePoint now) {
    const auto mine = shares.find(who);
    const Status target = mine == shares.end() ? wanted : std::max(wanted, mine->second.status);
    for (const auto& [other, share] : shares) {
      if (other == who) continue;
      if (share.status != target) return false;
      const bool knows = !secret.empty() && secret == password;
      if (mine == shares.end() && !knows && mutant_ != Mutant::AnyoneJoins) return false;
    }
    if (mine == shares.end()) {
      if (shares.empty()) secret = password;
      shares[who] = {wanted, password, now + ttl};
      issued_in[who].insert(era);
      return true;
    }
    Share& share = mine->second;
    share.claims = share.releasing ? 1 : share.claims + 1;
    share.releasing = false;
    share.status = target;
    share.expires = now + ttl;
    if (shares.size() == 1 && !password.empty()) secret = password;
    return true;
  }
  void release(SessionId who, bool pending) {
    const auto mine = shares.find(who);
    if (mine == shares.end() || mine->second.releasing || --mine->second.claims > 0) return;
    if (pending) {
      mine->second.releasing = true;
    } else {
      end(who);
    }
  }
  void drained(SessionId who) {
    if (shares.contains(who) && shares[who].releasing) end(who);
  }
  void lose(SessionId who) {
    if (shares.contains(who) && !shares[who].releasing) {
      end(who, mutant_ == Mutant::TakerOutlivesDeath);
    }
  }
  void expire(TimePoint now) {
    for (const auto& [who, share] : std::map(shares)) {
      if (share.expires <= now) lose(who);
    }
  }
  void stop(SessionId by) {
    ++era;
    for (const auto& [who, share] : std::map(shares)) {
      issued_in[who].clear();
      if (who == by && !share.releasing) {
        issued_in[who].insert(era);
        continue;
      }
      if (taker == who) taker.reset();
      shares.erase(who);
    }
  }
  void break_all() {
    taker.reset();
    if (mutant_ != Mutant::BreakSparesAHolder || shares.empty()) {
      shares.clear();
    } else {
      shares.erase(shares.begin());
    }
    for (auto& [who, moments] : issued_in) moments.clear();
    ++era;
  }
  bool take_over(SessionId who) {
    if (!shares.contains(who) || shares[who].releasing) return false;
    if (taker) return taker == who;
    taker = who;
    ++era;
    for (const auto& [other, share] : shares) {
      if (other != who && mutant_ != Mutant::FenceForgotten) issued_in[other].clear();
      issued_in[other].insert(era);
    }
    return true;
  }
  void give_back(SessionId who) {
    if (taker == who && mutant_ != Mutant::TakerOutlivesGiveBack) taker.reset();
  }
  bool may_start(SessionId who, std::optional<Era> issued, Status needed) const {
    const auto mine = shares.find(who);
    if (mine == shares.end()) {
      const bool others_master = !shares.empty() && shares.begin()->second.status == Status::Master;
      return needed == Status::Sensor && !others_master;
    }
    if (needed == Status::Sensor) return true;
    const auto valid = issued_in.find(who);
    return issued && valid->second.contains(*issued) && mine->second.status >= needed &&
           (!taker || taker == who);
  }

  std::map<SessionId, Share> shares;
  std::optional<SessionId> taker;
  std::string secret;
  Era era = 1;
  std::map<SessionId, std::set<Era>> issued_in;  ///< when a command must have been issued to start

 private:
  void end(SessionId who, bool keep_taker = false) {
    if (taker == who && !keep_taker) taker.reset();
    shares.erase(who);
    issued_in[who].clear();
    if (shares.empty()) ++era;
  }

  const Mutant mutant_;
};

/// What a program knows of the holders that is told changes only.
class Watcher {
 public:
  /// Asks for the changes after the newest one that it knows. Returns what is wrong with them.
  std::string ask(const RosterChanges& changes) {
    for (const RosterChange& change : changes.after(known_)) {
      if (change.number != known_ + 1) return "a change is lost or told twice";
      known_ = change.number;
      if (change.kind == RosterChange::Kind::Ended) {
        if (known_holders_.erase(change.holder.session) == 0) return "an unknown status ended";
      } else {
        known_holders_[change.holder.session] = change.holder;
      }
    }
    return known_ == changes.newest() ? "" : "the newest change is not told";
  }
  std::string difference(const Model& model) const {
    if (known_holders_.size() != model.shares.size()) return "a watcher knows other holders";
    for (const auto& [who, holder] : known_holders_) {
      const auto share = model.shares.find(who);
      if (share == model.shares.end() || share->second.status != holder.status ||
          share->second.releasing != holder.releasing ||
          holder.taken_over != (model.taker == who)) {
        return "a watcher knows another status of " + holder.client.user;
      }
    }
    return {};
  }

  static constexpr std::uint64_t start = 1000;

 private:
  std::uint64_t known_ = start;
  std::map<SessionId, Holder> known_holders_;
};

struct Issued {
  SessionId session{};
  std::optional<Era> era;
  Epoch epoch{};
  Status needed = Status::Actor;
};

class Schedule {
 public:
  Schedule(std::uint64_t seed, Mutant mutant) : random_(seed), model_(mutant), mutant_(mutant) {}

  /// Returns the first difference between table and model; empty when there is none.
  std::string run() {
    for (int step = 0; step < 20; ++step) {
      const std::string done = act();
      if (mutant_ != Mutant::ReleaseIsNotTold || !done.ends_with("releases")) {
        changes_.note(table_.roster(), now_, done);
      }
      std::string wrong = difference();
      if (wrong.empty() && step % 3 == 2) wrong = watch();
      if (!wrong.empty()) return "step " + std::to_string(step) + ", " + done + ": " + wrong;
      issue();
      wrong = judge();
      if (!wrong.empty()) return "step " + std::to_string(step) + ", " + done + ": " + wrong;
    }
    return {};
  }
  std::size_t held_off() const { return held_off_; }

 private:
  unsigned draw(unsigned below) { return static_cast<unsigned>(random_() % below); }
  SessionId any() { return SessionId{1 + draw(4)}; }

  std::string act() {
    const SessionId who = any();
    const std::string name = std::to_string(number(who));
    const bool pending = draw(2) == 0;
    switch (draw(25) / 2) {  // breaks are half as frequent
      case 0:
      case 1:
      case 2: {
        const Status wanted = draw(6) == 0 ? Status::Master : Status::Actor;
        const std::string password = draw(5) == 0 ? "" : draw(5) == 0 ? "wrong" : "right";
        const bool granted =
            table_.acquire(who, {name, "lab", "test", 1}, wanted, plain_proof(password), now_)
                .has_value();
        if (granted != model_.acquire(who, wanted, password, now_)) alarm_ = "acquired otherwise";
        return name + " acquires";
      }
      case 3:
        table_.release(who, table_.epoch(), pending ? Commands::Pending : Commands::None);
        model_.release(who, pending);
        return name + " releases";
      case 4:
        table_.drained(who);
        model_.drained(who);
        return name + " is drained";
      case 5:
        table_.lose(who);
        model_.lose(who);
        return name + " dies";
      case 6:
        now_ += 200ms;
        table_.renew(who, now_);
        if (model_.shares.contains(who)) model_.shares[who].expires = now_ + ttl;
        table_.expire(now_);
        model_.expire(now_);
        return "all but " + name + " are silent";
      case 7:
        table_.stop(who, "stopped");
        model_.stop(who);
        return name + " stops";
      case 12:
        table_.stop(SessionId{}, "broken", Denial::Reason::LeaseEnded);
        model_.break_all();
        return "an administrator breaks it";
      case 8:
        table_.give_back(who);
        model_.give_back(who);
        return name + " gives back";
      default: {
        const bool taken = table_.take_over(who, now_).has_value();
        if (taken != model_.take_over(who)) alarm_ = "taken over otherwise";
        return name + " takes over";
      }
    }
  }

  /// A client issues a command, under an epoch that it may know. Commands of earlier steps stay on
  /// their way.
  void issue() {
    const Epoch epoch = table_.epoch();
    if (epochs_.empty() || epochs_.back().second != epoch) epochs_.emplace_back(model_.era, epoch);
    Issued command{any(), std::nullopt, {}, Status(draw(3))};
    if (draw(8) != 0) {
      const auto& [era, under] =
          epochs_[epochs_.size() - 1 -
                  draw(std::min<unsigned>(3, static_cast<unsigned>(epochs_.size())))];
      command.era = era;
      command.epoch = under;
    }
    on_their_way_.push_back(command);
  }

  std::string judge() {
    for (const Issued& command : on_their_way_) {
      const auto may = table_.may_start(command.session, command.epoch, command.needed, now_);
      if (may.has_value() != model_.may_start(command.session, command.era, command.needed)) {
        return "a command of " + std::to_string(number(command.session)) +
               (may ? " starts" : " does not start: " + may.error().text);
      }
      if (may || command.needed == Status::Sensor) continue;
      if (may.error().reason == Denial::Reason::HeldOff) ++held_off_;
    }
    if (on_their_way_.size() > 4) on_their_way_.erase(on_their_way_.begin());
    return {};
  }

  /// Compares the holders, and checks what must hold whatever the model says.
  std::string difference() {
    if (!alarm_.empty()) return alarm_;
    const auto holders = table_.roster();
    if (holders.size() != model_.shares.size()) return "other holders";
    int takers = 0;
    for (const Holder& holder : holders) {
      const auto share = model_.shares.find(holder.session);
      if (share == model_.shares.end() || share->second.status != holder.status ||
          share->second.releasing != holder.releasing) {
        return "another status of " + holder.client.user;
      }
      if (holder.taken_over != (model_.taker == holder.session)) return "another taker";
      takers += holder.taken_over ? 1 : 0;
      if (holder.status != holders[0].status) return "two kinds of status";
    }
    if (holders.size() > 1 && model_.secret.empty()) return "two holders without a password";
    if (takers > 1) return "two takers";
    const bool rose = !last_ || table_.epoch() > *last_;
    if (table_.epoch() != last_.value_or(Epoch{}) && !rose) return "the epoch fell";
    if ((model_.era != last_era_) != (last_ != table_.epoch())) return "another epoch";
    last_ = table_.epoch();
    last_era_ = model_.era;
    return {};
  }

  std::string watch() {
    const std::string wrong = watcher_.ask(changes_);
    return wrong.empty() ? watcher_.difference(model_) : wrong;
  }

  std::mt19937_64 random_;
  TimePoint now_{10s};
  LeaseTable table_{IncarnationId{0x1234'5678'9abc'def0U}, ttl};
  RosterChanges changes_{Watcher::start};
  Watcher watcher_;
  Model model_;
  const Mutant mutant_;
  std::vector<std::pair<Era, Epoch>> epochs_;
  std::vector<Issued> on_their_way_;
  std::optional<Epoch> last_;
  Era last_era_ = 0;
  std::string alarm_;
  std::size_t held_off_ = 0;
};

std::uint64_t asked(const char* variable, std::uint64_t standard) {
  const char* const text = std::getenv(variable);
  return text == nullptr ? standard : std::strtoull(text, nullptr, 10);
}

struct Found {
  std::string alarm;
  std::uint64_t schedules = 0;
  std::size_t held_off = 0;
};

Found search(std::uint64_t count, Mutant mutant = Mutant::None) {
  Found found;
  const std::uint64_t first = asked("SCHEDULES_SEED", 1);
  for (std::uint64_t seed = first; seed < first + count && found.alarm.empty(); ++seed) {
    Schedule schedule(seed, mutant);
    found.alarm = schedule.run();
    if (!found.alarm.empty()) found.alarm = "seed " + std::to_string(seed) + ": " + found.alarm;
    found.held_off += schedule.held_off();
    ++found.schedules;
  }
  return found;
}

TEST(LeaseSchedules, StartOnlyWhatTheModelStartsAndOnlyTheTakersCommandsWhileTakenOver) {
  const Found found = search(asked("SCHEDULES", 100'000));
  EXPECT_EQ(found.alarm, "");
  EXPECT_GT(found.held_off, found.schedules / 10) << "few schedules reach a take-over";
}

class LeaseMutants : public ::testing::TestWithParam<Mutant> {};
INSTANTIATE_TEST_SUITE_P(Of, LeaseMutants,
                         ::testing::Values(Mutant::FenceForgotten, Mutant::TakerOutlivesDeath,
                                           Mutant::TakerOutlivesGiveBack, Mutant::AnyoneJoins,
                                           Mutant::BreakSparesAHolder, Mutant::ReleaseIsNotTold));

TEST_P(LeaseMutants, AreFound) {
  const Found found = search(1'000, GetParam());
  EXPECT_NE(found.alarm, "");
}

}  // namespace
}  // namespace gecos::access
