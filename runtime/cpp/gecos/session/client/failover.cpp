#include "gecos/session/client/failover.hpp"

#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <system_error>
#include <utility>

#include "gecos/base/thread.hpp"
#include "gecos/session/client/broker_client.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/context.hpp"

namespace gecos::session {
namespace {

constexpr Duration between_searches = std::chrono::milliseconds(30);
/// Maximum time of one search. It is short because a server that does not answer delays the
/// searches for other servers.
constexpr Duration longest_look = std::chrono::milliseconds(250);

/// Programs in all languages show this text. It advises to keep the Lab in a variable, because
/// Python destroys a Lab at once when no variable refers to it any more.
constexpr const char* no_lab =
    "the command is not sent again: its Lab is closed or no longer exists; keep the Lab in a "
    "variable as long as its proxies are used";

void end_as(PendingFailover& pending, const std::string& more) {
  pending.failure.text += "; " + more;
  pending.command->fail(std::move(pending.failure));
}

void end_late(PendingFailover& pending) {
  const bool started = pending.failure.state() != State::ConnectionFailed;
  const std::string what =
      "the deadline of '" + std::string(pending.command->again->name) +
      "' passed before a server was found to which the call could be sent again: ";
  pending.command->fail(
      {started ? Detail::TimedOut : Detail::Expired, what + pending.failure.text, {}, {}});
}

bool late(const PendingFailover& pending, const Clock& clock) {
  const TimePoint deadline = pending.command->again->deadline;
  return deadline != TimePoint::max() && clock.since_boot() >= deadline;
}

template <class T>
void append(std::vector<T>& to, std::vector<T> from) {
  std::move(from.begin(), from.end(), std::back_inserter(to));
}

}  // namespace

Failover::Failover(Context& lab) : lab_(lab), clock_(lab.runtime()->clock()), owner_(getpid()) {}

Failover::~Failover() { end(); }

void Failover::take(const std::shared_ptr<ClientConnection>& from,
                    std::vector<PendingFailover> commands) {
  if (getpid() != owner_) {
    for (PendingFailover& pending : commands) {
      end_as(pending,
             "the command is not sent again: its Lab belongs to the process that forked this one; "
             "create a Lab in this process");
    }
    return;
  }
  std::vector<PendingFailover> refused;
  std::string why = no_lab;
  {
    const MutexLock lock(mutex_);
    if (ended_) {
      refused = std::move(commands);
    } else if (!started()) {
      refused = std::move(commands);
      why = "the command is not sent again: no thread could be created to send it, see `ulimit -u`";
    } else {
      Search& search = search_of(from);
      for (PendingFailover& pending : commands) {
        (search.commands.size() < most_pending ? search.commands : refused)
            .push_back(std::move(pending));
      }
      why = "the command is not sent again: " + std::to_string(most_pending) +
            " other commands already wait for a server";
    }
  }
  for (PendingFailover& pending : refused) end_as(pending, why);
}

void Failover::look_for_another(const std::shared_ptr<ClientConnection>& from) {
  const MutexLock lock(mutex_);
  if (!ended_ && started()) search_of(from);
}

tl::expected<void, std::string> Failover::run_soon(Job job) {
  using namespace std::string_literals;
  if (getpid() != owner_) return tl::unexpected("this process was forked after its Lab was made"s);
  {
    const MutexLock lock(mutex_);
    if (ended_)
      return tl::unexpected("its Lab has ended; keep the Lab while its proxies are used"s);
    if (!started()) return tl::unexpected("no thread could be created to look for another medium"s);
    jobs_.push_back(std::move(job));
  }
  changed_.notify_one();
  return {};
}

bool Failover::started() {
  if (thread_.joinable()) return true;
  try {
    thread_ = start_thread("gecos-failover", [this] { run(); });
  } catch (const std::system_error&) {
    return false;
  }
  lab_.runtime()->maintenance().add(weak_from_this());
  return true;
}

Failover::Search& Failover::search_of(const std::shared_ptr<ClientConnection>& from) {
  for (Search& search : searches_) {
    if (search.from == from) return search;
  }
  changed_.notify_one();
  lab_.runtime()->maintenance().wake();
  return searches_.emplace_back(Search{from, {}, {}, "there was no time to look for a server"});
}

NextTick Failover::on_tick(TimePoint now) {
  std::vector<std::pair<PendingFailover, std::string>> over;
  bool idle = false;
  {
    const MutexLock lock(mutex_);
    idle = searches_.empty();
    for (Search& search : searches_) {
      std::erase_if(search.commands, [&](PendingFailover& pending) {
        if (pending.command->terminal()) return true;
        if (now < pending.give_up && !late(pending, clock_)) return false;
        over.emplace_back(std::move(pending), search.why);
        return true;
      });
    }
  }
  for (auto& [pending, why] : over) {
    if (late(pending, clock_)) {
      end_late(pending);
    } else {
      end_as(pending, "no server was found in time: " + why);
    }
  }
  return idle ? TimePoint::max() : now + Maintenance::tick;
}

void Failover::run() {
  MutexLock lock(mutex_);
  while (!ended_) {
    // The search is destroyed while the mutex is not held, because the end of a session takes a
    // while.
    std::vector<Search> done;
    const auto is_done = [](const Search& search) {
      return search.commands.empty() && (search.from->lost() || !search.from->unreachable());
    };
    const auto open = std::stable_partition(searches_.begin(), searches_.end(), is_done);
    std::move(searches_.begin(), open, std::back_inserter(done));
    searches_.erase(searches_.begin(), open);
    if (!done.empty()) {
      const MutexUnlock unlocked(mutex_);
      done.clear();
      continue;
    }
    if (!jobs_.empty()) {
      run_job();
      continue;
    }
    const auto next = std::ranges::min_element(searches_, {}, &Search::next);
    if (next == searches_.end()) {
      while (!ended_ && searches_.empty() && jobs_.empty()) changed_.wait(lock);
    } else if (const TimePoint when = next->next; when > std::chrono::steady_clock::now()) {
      changed_.wait_until(lock, when);
    } else {
      look(next->from);
    }
  }
}

/// Runs the first waiting job. Releases the mutex while the job runs and while the job is
/// destroyed.
void Failover::run_job() {
  Job job = std::move(jobs_.front());
  jobs_.pop_front();
  const MutexUnlock unlocked(mutex_);
  job(lab_);
  job = {};
}

void Failover::look(std::shared_ptr<ClientConnection> from) {
  tl::expected<std::shared_ptr<ClientConnection>, std::string> found;
  std::vector<PendingFailover> commands;
  {
    const MutexUnlock unlocked(mutex_);
    found = find(*from);
    if (found) {
      from->failover().set_successor(*found);
      if (!from->lost()) commands = from->failover().detach_repeatable();
    }
  }
  if (found) {
    append(commands, std::exchange(search_of(from).commands, {}));
    const MutexUnlock unlocked(mutex_);
    commands = send_to(**found, std::move(commands));
    found->reset();  // done while the mutex is not held, because the destruction takes a while
  }
  Search& search = search_of(from);
  append(search.commands, std::move(commands));
  search.next = std::chrono::steady_clock::now() + between_searches;
  if (!found) search.why = std::move(found.error());
}

tl::expected<std::shared_ptr<ClientConnection>, std::string> Failover::find(
    ClientConnection& from) {
  if (auto successor = from.failover().successor()) return successor;
  const ConnectTarget& target = from.failover().connect_target();
  if (!from.lost()) {
    const auto entry = look_up(lab_, target.name, deadline_after(longest_look));
    if (!entry) return tl::unexpected(entry.error());
    if (entry->boot == from.welcome().incarnation) {
      return tl::unexpected(std::string("no other server serves the object"));
    }
  }
  CreateOptions options = target.options;
  options.patience = longest_look;
  auto created = open_object(lab_, target.wanted, target.name, options);
  if (!created) return tl::unexpected(std::move(created.error().reason));
  return std::move(*created);
}

/// Sends `commands` in the session `found`. Returns the commands for which the session had no room.
std::vector<PendingFailover> Failover::send_to(ClientConnection& found,
                                               std::vector<PendingFailover> commands) {
  std::vector<PendingFailover> back;
  for (PendingFailover& pending : commands) {
    const auto& again = *pending.command->again;
    if (pending.command->terminal()) continue;
    if (again.sessions >= most_sessions) {
      end_as(pending, "the command is not sent again: it was sent in " +
                          std::to_string(again.sessions) + " sessions that were lost");
    } else if (late(pending, clock_)) {
      end_late(pending);
    } else if (const auto sent = found.failover().send_again(pending.command); !sent) {
      pending.command->fail(sent.error());
    } else if (!*sent) {
      back.push_back(std::move(pending));
    }
  }
  return back;
}

void Failover::end() {
  std::vector<Search> open;
  std::thread thread;
  {
    const MutexLock lock(mutex_);
    ended_ = true;
    thread = std::exchange(thread_, {});
  }
  changed_.notify_one();
  if (thread.joinable()) {
    if (getpid() != owner_) {
      thread.detach();  // the thread does not exist in a forked child
    } else {
      thread.join();
    }
  }
  {
    const MutexLock lock(mutex_);
    open.swap(searches_);
  }
  for (Search& search : open) {
    for (PendingFailover& pending : search.commands) end_as(pending, no_lab);
  }
}

}  // namespace gecos::session
