// Brokers, servers and watchers on random schedules with a clock of their own, against a model that
// keeps a table of servers and knows nothing of how a directory or a view works.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>
#include <random>

#include "gecos/broker/directory.hpp"
#include "gecos/session/client/list_view.hpp"

namespace gecos::broker {
namespace {

using session::ListView;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration silence = milliseconds(1500);
constexpr Duration free_after = seconds(10);

/// A life of a server with one object.
struct Life {
  Entry entry;
  Host host = Host::Other;
  bool alive = true;               ///< its process
  std::uint64_t session = 0;       ///< with the present broker; 0: none
  std::optional<TimePoint> heard;  ///< when the broker heard it last, while it is silent
  bool expected = false;           ///< silent; the present broker has not said so yet
};

/// What a watcher should be told.
struct Event {
  std::string name;
  std::uint64_t boot = 0;
  Presence presence = Presence::ONLINE;
  friend bool operator==(const Event&, const Event&) = default;
};
std::ostream& operator<<(std::ostream& out, const Event& event) {
  return out << event.name << '/' << event.boot << ' ' << event.presence;
}

struct Watching {
  ListView view{};
  std::vector<Event> told{};
  std::map<std::string, Event> state{};  ///< what `told` adds up to
  std::size_t from = 0;                  ///< index in `World::events_` of what it is told next
  bool one_broker = true;                ///< it was told of one broker only, and skipped nothing
};

class World {
 public:
  explicit World(std::uint32_t seed) : random_(seed) { new_broker(); }

  void step() {
    now_ += milliseconds(below(4) == 0 ? below(4000) : below(200));
    on_tick();
    switch (below(13)) {
      case 0:
      case 1:
      case 2:
        return serve();
      case 3:
        return withdraw();
      case 4:
      case 5:
        return fall_silent();
      case 6:
        return kill();
      case 7:
        return come_back();
      case 8:
        return free();
      case 9:
        if (below(4) == 0) restart_broker();
        return;
      default:
        return watch(watchers_[below(watchers_.size())]);
    }
  }

  /// After it every watcher knows what is true.
  void settle() {
    now_ += ListView::servers_return_within;
    on_tick();
    for (Watching& watcher : watchers_) {
      watch(watcher);
      std::map<std::string, Event> truth;
      for (const Life& life : lives_) {
        if (life.session == 0 && !life.heard) continue;
        const Presence presence = life.heard ? Presence::SILENT : Presence::ONLINE;
        truth[life.entry.name] = {life.entry.name, life.entry.boot, presence};
      }
      EXPECT_EQ(watcher.state, truth);
      if (!watcher.one_broker) continue;
      const std::vector<Event> all(events_.begin() + static_cast<std::ptrdiff_t>(watcher.from),
                                   events_.end());
      EXPECT_EQ(watcher.told, all) << "each change once, in its order";
      ++exact_;
    }
  }
  int exact() const { return exact_; }

 private:
  std::size_t below(std::size_t most) { return random_() % most; }

  void new_broker() {
    directory_ = std::make_unique<Directory>(
        now_, DirectoryOptions{seconds(1), free_after, ++broker_lives_});
    started_ = now_;
  }
  /// What the broker does when time has passed: silent servers of its host that it expected are
  /// told as silent.
  void on_tick() {
    directory_->on_tick(now_);
    if (now_ < started_ + Directory::servers_return_within) return;
    std::map<std::string, const Life*> by_name;
    for (Life& life : lives_) {
      if (std::exchange(life.expected, false)) by_name[life.entry.name] = &life;
    }
    for (const auto& [name, life] : by_name) happened(*life, Presence::SILENT);
  }
  /// All servers that live and are heard find the next broker within its first second. Of the
  /// others, it knows those of its host.
  void restart_broker() {
    new_broker();
    for (Life& life : lives_) {
      const bool known = life.session != 0 || life.heard;
      life.expected = known && life.host == Host::Same;
      if (life.expected) directory_->expect(life.entry);
      if (life.host == Host::Other) life.heard.reset();
    }
    for (Watching& watcher : watchers_) watcher.one_broker = false;
    for (std::size_t i = below(3); i > 0; --i) watch(watchers_[below(watchers_.size())]);
    for (Life& life : lives_) {
      if (std::exchange(life.session, 0) == 0) continue;
      now_ += milliseconds(below(20));
      enlist(life, now_ - started_ + seconds(5));
      if (below(2) == 0) watch(watchers_[below(watchers_.size())]);
    }
    now_ += seconds(1);
  }

  void serve() {
    Life life;
    life.entry.name = std::string(1, static_cast<char>('A' + below(4)));
    life.entry.boot = ++incarnations_;
    life.entry.pid = static_cast<std::int32_t>(incarnations_);
    life.entry.interface_name = "robcl::Rx90";
    life.host = below(2) == 0 ? Host::Same : Host::Other;
    if (now_ < started_ + seconds(1)) now_ = started_ + seconds(1);
    lives_.push_back(life);
    enlist(lives_.back(), Duration::zero());
    std::erase_if(lives_,
                  [](const Life& one) { return one.session == 0 && !one.heard && !one.alive; });
  }

  /// Compares with what the model says: who else has the name keeps it while it is heard, lives on
  /// this host, or was heard less than `free_after` ago.
  void enlist(Life& life, Duration served_for) {
    Life* other = nullptr;
    for (Life& one : lives_) {
      const bool known = one.session != 0 || one.heard;
      if (&one != &life && known && one.entry.name == life.entry.name) other = &one;
    }
    const bool stays_with_other = other && (other->session != 0 || other->host == Host::Same ||
                                            now_ < *other->heard + free_after);
    const std::uint64_t session = ++sessions_;
    const auto done =
        directory_->enlist({session, life.entry.boot, served_for, life.host}, life.entry, now_);
    ASSERT_EQ(done.has_value(), !stays_with_other)
        << life.entry.name << " at " << now_.time_since_epoch().count();
    if (stays_with_other) {
      life.alive = life.session != 0;  // a new server that is refused ends
      return;
    }
    if (other) other->heard.reset();
    life.session = session;
    life.heard.reset();
    life.expected = false;
    happened(life, Presence::ONLINE);
  }

  Life* some(auto which) {
    std::vector<Life*> found;
    for (Life& life : lives_) {
      if (which(life)) found.push_back(&life);
    }
    return found.empty() ? nullptr : found[below(found.size())];
  }
  Life* online() {
    return some([](const Life& life) { return life.session != 0; });
  }

  void withdraw() {
    Life* life = online();
    if (life == nullptr) return;
    ASSERT_TRUE(directory_->withdraw(std::exchange(life->session, 0), life->entry.name));
    happened(*life, Presence::GONE);
    life->alive = false;
  }
  /// It is frozen, cut off, or dead on another host.
  void fall_silent() {
    Life* life = online();
    if (life == nullptr) return;
    life->heard = now_;
    now_ += silence;
    directory_->end_session(std::exchange(life->session, 0), *life->heard);
    happened(*life, Presence::SILENT);
  }
  void kill() {
    Life* life = some([](const Life& one) {
      return one.host == Host::Same && one.alive && (one.session != 0 || one.heard);
    });
    if (life == nullptr) return;
    EXPECT_EQ(directory_->process_ended(life->entry.pid).size(), 1u);
    life->session = 0;
    life->heard.reset();
    life->alive = false;
    if (!std::exchange(life->expected, false)) happened(*life, Presence::GONE);
  }
  void come_back() {
    Life* life = some([](const Life& one) { return one.session == 0 && one.heard; });
    if (life != nullptr) enlist(*life, seconds(5));
  }
  void free() {
    const std::string name(1, static_cast<char>('A' + below(4)));
    Life* silent = some([&](const Life& one) { return one.heard && one.entry.name == name; });
    const bool may = silent && silent->host == Host::Other;
    ASSERT_EQ(directory_->free(name).has_value(), may);
    if (!may) return;
    silent->heard.reset();
    happened(*silent, Presence::GONE);
  }

  void happened(const Life& life, Presence presence) {
    events_.push_back({life.entry.name, life.entry.boot, presence});
  }

  void watch(Watching& watcher) {
    const ListRevision before = watcher.view.revision();
    for (const Registration& one : watcher.view.take(directory_->changes(before, now_), now_)) {
      const Event event{one.entry.name, one.entry.boot, one.presence};
      const auto last = watcher.state.find(event.name);
      if (last == watcher.state.end()) {
        EXPECT_NE(event.presence, Presence::GONE) << event;
      } else {
        EXPECT_NE(last->second, event) << "told twice";
      }
      watcher.told.push_back(event);
      if (event.presence == Presence::GONE) {
        watcher.state.erase(event.name);
      } else {
        watcher.state[event.name] = event;
      }
    }
    if (before.life != 0) return;
    watcher.told.clear();  // what was there at first is its state
    watcher.from = events_.size();
    watcher.one_broker = true;
  }

  std::mt19937 random_;
  TimePoint now_{std::chrono::hours(1)};
  TimePoint started_;
  std::unique_ptr<Directory> directory_;
  std::uint64_t broker_lives_ = 0;
  std::uint64_t incarnations_ = 0;
  std::uint64_t sessions_ = 0;
  std::vector<Life> lives_;
  std::vector<Event> events_;
  std::vector<Watching> watchers_ = std::vector<Watching>(3);
  int exact_ = 0;
};

TEST(Watching, OnRandomSchedulesEachChangeIsToldOnceAndNamesGoToWhoMayHaveThem) {
  constexpr std::uint32_t schedules = 5000;
  int exact = 0;
  for (std::uint32_t seed = 0; seed < schedules && !HasFailure(); ++seed) {
    World world(seed);
    for (int step = 0; step < 60 && !HasFailure(); ++step) world.step();
    world.settle();
    exact += world.exact();
    EXPECT_FALSE(HasFailure()) << "seed " << seed;
  }
  EXPECT_GT(exact, 1000) << "watchers that saw one broker only";
}

/// The servers of a laboratory register with the next broker, in any order and some of them late.
TEST(Watching, NothingIsToldOfABrokerThatIsRestartedUnderFiftyServers) {
  std::mt19937 random(7);
  TimePoint now{std::chrono::hours(1)};
  const auto entry = [](int i) {
    Entry one;
    one.name = "ARM" + std::to_string(i);
    one.boot = static_cast<std::uint64_t>(i) + 1;
    return one;
  };
  ListView view;
  std::size_t told = 0;
  for (std::uint64_t life = 1; life <= 20; ++life) {
    Directory directory(now, {.life = life});
    std::vector<int> servers(50);
    for (int i = 0; i < 50; ++i) servers[static_cast<std::size_t>(i)] = i;
    std::ranges::shuffle(servers, random);
    for (const int i : servers) {
      const auto boot = static_cast<std::uint64_t>(i) + 1;
      ASSERT_TRUE(directory.enlist({boot, boot, seconds(60), Host::Same}, entry(i), now));
      now += milliseconds(random() % 20);
      if (random() % 4 == 0) told += view.take(directory.changes(view.revision(), now), now).size();
    }
    told += view.take(directory.changes(view.revision(), now), now).size();
    EXPECT_EQ(told, 50u) << "at first each object once, then nothing";
    now += seconds(60);
    told += view.missing(now).size();
  }
  EXPECT_EQ(told, 50u);
}

}  // namespace
}  // namespace gecos::broker
