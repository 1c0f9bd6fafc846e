#include "gecos/session/client/connection_reader.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {
namespace {

/// A client may rest (ConnectionReader::rest) only when it has at least this many open calls.
constexpr std::size_t calls_of_a_flood = 32;
/// Duration of a rest (ConnectionReader::rest). It is about the time for which the client has
/// polled without success before the rest.
constexpr Duration rest_of_a_flood = std::chrono::microseconds(400);

}  // namespace

ConnectionReader::ConnectionReader(Runtime& runtime, media::Connection& connection,
                                   CallSender& calls, PacketReceiver& receiver, EndListener& end)
    : owner_(getpid()),
      runtime_(runtime),
      connection_(connection),
      calls_(calls),
      receiver_(receiver),
      end_(end),
      reliable_(connection.capabilities().reliable),
      spin_(system_clock()) {
  descriptors_.reserve(connection.descriptors().size() + 1);  // so that `sleep` allocates no memory
}

void ConnectionReader::poll_once() {
  std::size_t taken = 0;
  if (leader_lock_.try_take()) {
    taken = read_all();
    if (loss_look_due_.load(std::memory_order_relaxed)) {
      loss_look_due_.store(false, std::memory_order_relaxed);
      look_for_loss();
    }
    leader_lock_.drop();
  } else if (reliable_ && leader_lock_.borrow()) {
    // The server wakes the leader for each packet that can end the leader's wait, so this thread
    // does not have to wake the leader.
    taken = read_all();
    leader_lock_.release();
  }
  if (taken != 0) leader_lock_.notify(nullptr);
}

void ConnectionReader::read_after_rest() {
  if (getpid() != owner_) return;
  look_for_loss_soon();
  poll_once();
}

bool ConnectionReader::wait(const void* subject, FunctionRef<bool()> done, TimePoint deadline) {
  if (done()) return true;
  for (;;) {
    if (leader_lock_.try_take()) {
      const bool finished = lead(done, deadline);
      leader_lock_.drop();
      // From now on the maintenance thread reads packets for the registered watchers.
      if (has_watchers()) runtime_.maintenance().wake();
      return finished;
    }
    switch (leader_lock_.follow(subject, done, deadline)) {
      case LeaderLock::Woken::Done:
        return true;
      case LeaderLock::Woken::TimedOut:
        return done();
      case LeaderLock::Woken::Notified:
        break;
    }
  }
}

bool ConnectionReader::lead(FunctionRef<bool()> done, TimePoint deadline) {
  bool rested = false;
  bool slept = false;
  spin_.begin();
  for (;;) {
    const std::size_t taken = read_all();
    if (slept && taken == 0) look_for_loss();
    const bool finished = done();
    if (std::exchange(slept, false)) {
      spin_.woke(connection_.peer_whereabouts().rang_at,
                 finished ? media::Woken::ByAnswer : media::Woken::Early);
      spin_.begin();
    }
    if (finished) return true;
    if (taken != 0) {
      leader_lock_.notify(nullptr);
      // The deadline is checked here too, because replies to calls of other threads may arrive
      // without a pause.
      if (deadline != TimePoint::max() && std::chrono::steady_clock::now() >= deadline)
        return false;
      rested = false;
      spin_.begin();
    } else if (!spin_.again([this] { return media::place_of(connection_.peer_whereabouts()); })) {
      if (std::chrono::steady_clock::now() >= deadline) return false;
      rested = !rested && rest(done, deadline);
      if (rested) {
        spin_.begin();
      } else {
        sleep(done, deadline);
        slept = true;
      }
      leader_lock_.notify(nullptr);
    }
  }
}

/// If this client has many open calls and shares a core with its server, it leaves the core to the
/// server for a while. Otherwise each reply would wake this client, which would then take the core
/// from the server while other clients wait for their replies.
bool ConnectionReader::rest(FunctionRef<bool()> done, TimePoint deadline) {
  if (!spin_.gave_way()) return false;
  if (calls_.open() < calls_of_a_flood) return false;
  quiet_leader();
  if (done()) return true;
  const std::array woken_by{leader_event_.descriptor()};
  media::sleep_on(woken_by, std::min(deadline, std::chrono::steady_clock::now() + rest_of_a_flood));
  return true;
}

void ConnectionReader::sleep(FunctionRef<bool()> done, TimePoint deadline) {
  quiet_leader();
  if (connection_.prepare_to_sleep() && !done()) {
    descriptors_.assign(connection_.descriptors().begin(), connection_.descriptors().end());
    descriptors_.push_back(leader_event_.descriptor());
    leader_lock_.rest();
    media::sleep_on(descriptors_, deadline);
    leader_lock_.resume();
  }
  connection_.woke();
}

void ConnectionReader::wake_all() {
  // A forked child has none of the threads, but shares the descriptor of the event, which its
  // parent would not drain.
  if (getpid() != owner_) return;
  leader_lock_.notify_all();
  leader_event_.notify();
  leader_called_.store(true);  // must follow notify(), otherwise the event might never be drained
}

void ConnectionReader::quiet_leader() {
  if (leader_called_.exchange(false)) leader_event_.drain();
}

std::size_t ConnectionReader::read_all() {
  std::size_t taken = 0;
  while (const auto packet = connection_.receive()) {
    if (const auto ended = receiver_.take(*packet)) leader_lock_.notify(ended.get());
    ++taken;
  }
  return taken;
}

void ConnectionReader::look_for_loss() {
  const media::Loss loss = connection_.loss();
  if (loss == media::Loss::None || calls_.lost()) return;
  read_all();  // reads the replies that the server sent before the loss
  end_.on_loss(loss);
}

void ConnectionReader::add_watcher() {
  watchers_.fetch_add(1, std::memory_order_relaxed);
  runtime_.maintenance().wake();
}

void ConnectionReader::watch(std::vector<pollfd>& into) {
  if (calls_.lost() || !has_watchers() || !leader_lock_.try_take()) return;
  watching_ = true;
  if (connection_.prepare_to_sleep()) {
    for (const int descriptor : connection_.descriptors()) into.push_back({descriptor, POLLIN, 0});
  } else {
    runtime_.maintenance().wake();
  }
  leader_lock_.rest();
}

void ConnectionReader::unwatch() {
  if (!watching_) return;
  watching_ = false;
  leader_lock_.resume();
  connection_.woke();
  read_all();
  look_for_loss();
  leader_lock_.drop();
  leader_lock_.notify(nullptr);
}

void ConnectionReader::abandon_watch() {
  if (watching_) leader_lock_.drop();
}

}  // namespace gecos::session
