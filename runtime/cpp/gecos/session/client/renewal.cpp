#include "gecos/session/client/renewal.hpp"

#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <system_error>
#include <utility>

#include "gecos/base/thread.hpp"
#include "gecos/session/client/lab_core.hpp"
#include "gecos/session/client/linked_session.hpp"
#include "gecos/session/client/registry.hpp"

namespace gecos::session {
namespace {

constexpr Duration between_looks = std::chrono::milliseconds(30);
/// Who does not answer so long holds up the search for others.
constexpr Duration longest_look = std::chrono::milliseconds(250);

void end_as(Adrift& adrift, const std::string& more) {
  adrift.failure.text += "; " + more;
  adrift.command->fail(std::move(adrift.failure));
}

void end_late(Adrift& adrift) {
  const bool started = adrift.failure.state() != State::ConnectionFailed;
  const std::string what =
      "the deadline of '" + std::string(adrift.command->again->name) + "' passed ";
  adrift.command->fail({started ? Detail::TimedOut : Detail::Expired,
                        what + "while it could not be sent again: " + adrift.failure.text,
                        {},
                        {}});
}

bool late(const Adrift& adrift, const Clock& clock) {
  const TimePoint deadline = adrift.command->again->deadline;
  return deadline != TimePoint::max() && clock.since_boot() >= deadline;
}

template <class T>
void append(std::vector<T>& to, std::vector<T> from) {
  std::move(from.begin(), from.end(), std::back_inserter(to));
}

}  // namespace

Renewal::Renewal(LabCore& lab) : lab_(lab), owner_(getpid()) {}

Renewal::~Renewal() { end(); }

void Renewal::take(const std::shared_ptr<LinkedSession>& from, std::vector<Adrift> commands) {
  if (getpid() != owner_) {
    for (Adrift& adrift : commands) {
      end_as(adrift,
             "it is not sent again: its Lab belongs to the process that forked this one: make your "
             "own");
    }
    return;
  }
  std::vector<Adrift> refused;
  std::string why = "it is not sent again: its Lab is closed";
  {
    const Lock lock(mutex_);
    if (ended_) {
      refused = std::move(commands);
    } else if (!started()) {
      refused = std::move(commands);
      why = "it is not sent again: no thread can be had for that, see `ulimit -u`";
    } else {
      Search& search = search_of(from);
      for (Adrift& adrift : commands) {
        (search.commands.size() < most_adrift ? search.commands : refused)
            .push_back(std::move(adrift));
      }
      why = "it is not sent again: " + std::to_string(most_adrift) +
            " others wait for a server already";
    }
  }
  for (Adrift& adrift : refused) end_as(adrift, why);
}

void Renewal::look_for_another(const std::shared_ptr<LinkedSession>& from) {
  const Lock lock(mutex_);
  if (!ended_ && started()) search_of(from);
}

/// With the mutex; not after the end.
bool Renewal::started() {
  if (thread_.joinable()) return true;
  try {
    thread_ = start_thread("gecos-renewal", [this] { run(); });
  } catch (const std::system_error&) {
    return false;
  }
  lab_.runtime()->housekeeping().tend(weak_from_this());
  return true;
}

/// With the mutex.
Renewal::Search& Renewal::search_of(const std::shared_ptr<LinkedSession>& from) {
  for (Search& search : searches_) {
    if (search.from == from) return search;
  }
  changed_.notify_one();
  lab_.runtime()->housekeeping().wake();
  return searches_.emplace_back(Search{from, {}, {}, "there was no time to look for one"});
}

TimePoint Renewal::tend(TimePoint now) {
  const Clock& clock = lab_.runtime()->clock();
  std::vector<std::pair<Adrift, std::string>> over;
  bool idle = false;
  {
    const Lock lock(mutex_);
    idle = searches_.empty();
    for (Search& search : searches_) {
      std::erase_if(search.commands, [&](Adrift& adrift) {
        if (adrift.command->terminal()) return true;
        if (now < adrift.give_up && !late(adrift, clock)) return false;
        over.emplace_back(std::move(adrift), search.why);
        return true;
      });
    }
  }
  for (auto& [adrift, why] : over) {
    if (late(adrift, clock)) {
      end_late(adrift);
    } else {
      end_as(adrift, "there was none to send it to again in time: " + why);
    }
  }
  return idle ? TimePoint::max() : now + Housekeeping::tick;
}

void Renewal::run() {
  Lock lock(mutex_);
  while (!ended_) {
    std::vector<Search> done;  // may be the last to have their sessions, which take a while to end
    const auto is_done = [](const Search& search) {
      return search.commands.empty() && (search.from->lost() || !search.from->unreachable());
    };
    const auto open = std::stable_partition(searches_.begin(), searches_.end(), is_done);
    std::move(searches_.begin(), open, std::back_inserter(done));
    searches_.erase(searches_.begin(), open);
    if (!done.empty()) {
      lock.unlock();
      done.clear();
      lock.lock();
      continue;
    }
    const auto next = std::ranges::min_element(searches_, {}, &Search::next);
    if (next == searches_.end()) {
      changed_.wait(lock, [this] { return ended_ || !searches_.empty(); });
    } else if (const TimePoint when = next->next; when > std::chrono::steady_clock::now()) {
      changed_.wait_until(lock, when);
    } else {
      look(next->from, lock);
    }
  }
}

/// Gives the mutex up meanwhile, in which the search may end. `from` is a copy therefore.
void Renewal::look(std::shared_ptr<LinkedSession> from, Lock& lock) {
  lock.unlock();
  auto found = find(*from);
  std::vector<Adrift> commands;
  if (found) {
    from->followed_by(*found);
    if (!from->lost()) commands = from->cast_off_repeatable();
  }
  lock.lock();
  if (found) {
    append(commands, std::exchange(search_of(from).commands, {}));
    lock.unlock();
    commands = send_to(**found, std::move(commands));
    found->reset();  // its end takes a while
    lock.lock();
  }
  Search& search = search_of(from);
  append(search.commands, std::move(commands));
  search.next = std::chrono::steady_clock::now() + between_looks;
  if (!found) search.why = std::move(found.error());
}

tl::expected<std::shared_ptr<LinkedSession>, std::string> Renewal::find(LinkedSession& from) {
  if (auto follower = from.follower()) return follower;
  const Origin& origin = from.origin();
  if (!from.lost()) {
    const auto entry = look_up(lab_, origin.name, deadline_after(longest_look));
    if (!entry) return tl::unexpected(entry.error());
    if (entry->boot == from.welcome().boot) {
      return tl::unexpected(std::string("no other server has taken its place"));
    }
  }
  CreateOptions options = origin.options;
  options.patience = longest_look;
  auto created = open_object(lab_, origin.wanted, origin.name, options);
  if (!created) return tl::unexpected(std::move(created.error().reason));
  return std::move(*created);
}

/// Gives back those that it could not take.
std::vector<Adrift> Renewal::send_to(LinkedSession& found, std::vector<Adrift> commands) {
  std::vector<Adrift> back;
  for (Adrift& adrift : commands) {
    const auto& again = *adrift.command->again;
    if (adrift.command->terminal()) continue;
    if (again.sessions >= most_sessions) {
      end_as(adrift, "it is not sent again, because so it went " + std::to_string(again.sessions) +
                         " times");
    } else if (late(adrift, lab_.runtime()->clock())) {
      end_late(adrift);
    } else if (const auto sent = found.send_again(adrift.command); !sent) {
      adrift.command->fail(sent.error());
    } else if (!*sent) {
      back.push_back(std::move(adrift));
    }
  }
  return back;
}

void Renewal::end() {
  std::vector<Search> open;
  std::thread thread;
  {
    const Lock lock(mutex_);
    ended_ = true;
    thread = std::exchange(thread_, {});
  }
  changed_.notify_one();
  if (thread.joinable()) {
    if (getpid() != owner_) {
      thread.detach();  // a forked child has no such thread
    } else {
      thread.join();
    }
  }
  {
    const Lock lock(mutex_);
    open.swap(searches_);
  }
  for (Search& search : open) {
    for (Adrift& adrift : search.commands)
      end_as(adrift, "it is not sent again: its Lab is closed");
  }
}

}  // namespace gecos::session
