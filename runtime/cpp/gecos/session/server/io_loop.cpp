#include "gecos/session/server/io_loop.hpp"

#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "gecos/base/log.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/base/thread.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {
namespace {

constexpr std::uint64_t event_key = 0;
constexpr std::uint64_t endpoint_bit = std::uint64_t{1} << 63;
constexpr Duration stays_active = std::chrono::milliseconds(10);
/// Number of turns between two checks for epoll events. A turn that found a packet takes longer and
/// counts as `busy_turn` turns, so that a client that was silent never waits long.
constexpr unsigned turns_between_events = 8192;
constexpr unsigned busy_turn = 128;

}  // namespace

IoLoop::Epoll::Epoll() : descriptor(epoll_create1(EPOLL_CLOEXEC)) {
  if (descriptor < 0) throw_system_error("epoll_create1", errno);
}
IoLoop::Epoll::~Epoll() { close(descriptor); }

IoLoop::IoLoop(std::shared_ptr<Runtime> runtime)
    : runtime_(std::move(runtime)), spin_(system_clock()) {
  add_descriptor(event_.descriptor(), event_key);
  main_ = start_thread("gecos-io", [this] { run(); });
  try {
    standby_ = start_thread("gecos-standby", [this] { run_standby(); });
  } catch (...) {
    ended_.store(true);
    event_.notify();
    main_.join();
    throw;
  }
}

IoLoop::~IoLoop() { end(); }

void IoLoop::serve(std::shared_ptr<ObjectHost> object, std::shared_ptr<media::Acceptor> acceptor) {
  object->streams().offer(acceptor);
  {
    const MutexLock list(list_mutex_);
    new_endpoints_.push_back(
        std::make_unique<Endpoint>(Endpoint{std::move(object), std::move(acceptor)}));
  }
  event_.notify();
}

void IoLoop::add_endpoints() {
  std::vector<std::unique_ptr<Endpoint>> opened;
  {
    const MutexLock list(list_mutex_);
    opened.swap(new_endpoints_);
  }
  for (auto& endpoint : opened) {
    const auto key = endpoint_bit | endpoints_.size();
    for (const int descriptor : endpoint->acceptor->descriptors()) add_descriptor(descriptor, key);
    endpoints_.push_back(std::move(endpoint));
    accept(*endpoints_.back());
  }
}

void IoLoop::add_descriptor(int descriptor, std::uint64_t key) {
  epoll_event event{};
  event.events = EPOLLIN | EPOLLET;
  event.data.u64 = key;
  if (epoll_ctl(epoll_.descriptor, EPOLL_CTL_ADD, descriptor, &event) != 0 && errno != EEXIST) {
    throw_system_error("epoll_ctl", errno);
  }
}

// Polling

void IoLoop::run() {
  const MutexLock polling(polling_);
  main_id_ = std::this_thread::get_id();
  spin_.begin();
  while (!ended_.load()) turn();
  event_.notify();  // wakes a standby that sleeps on the same events
}

void IoLoop::run_standby() {
  for (;;) {
    {
      MutexLock called(standby_mutex_);
      while (!standby_wanted_ && !ended_.load()) standby_called_.wait(called);
      standby_wanted_ = false;
    }
    if (ended_.load()) return;
    const MutexLock polling(polling_);
    while (!ended_.load() && main_is_inside()) turn();
    event_.notify();  // the standby may have drained events for which the main thread waits
  }
}

void IoLoop::run_handlers(ObjectHost& object, std::shared_ptr<ServerCall> started,
                          Starter starter) {
  const bool main = starter == Starter::Poller;
  const auto turn = handler_turn_.load(std::memory_order_relaxed);
  if (main) handler_turn_.store(turn + 1, std::memory_order_release);
  polling_.unlock();
  object.run_ready(starter, std::move(started));
  if (main) handler_turn_.store(turn + 2, std::memory_order_release);
  if (polling_.try_lock()) return;
  event_.notify();  // a standby polls and may sleep: wake it so that it releases polling_
  polling_.lock();
}

void IoLoop::turn() {
  const bool busy = poll_active();
  turns_ += busy ? busy_turn : 1;
  if (turns_ >= turns_between_events) {
    turns_ = 0;
    retire_idle(runtime_->clock().now());
    take_events(0);
  }
  if (busy) spin_.begin();
  if (busy || (!active_.empty() && spin_.again([this] {
        polling_.assert_held();
        return peers();
      }))) {
    return;
  }
  // The call of take_events() above may have drained the event that announces `ended_`, so check
  // `ended_` again.
  if (prepare_all_to_sleep() && !ended_.load()) {
    woken_ = media::Woken::Early;
    rang_at_ = TimePoint{};
    take_events(-1);
    spin_.woke(rang_at_, woken_);
  }
  spin_.begin();
}

/// A sleeping client on another core does not count: it sends nothing soon. A sleeping client on
/// this core counts: a reply of this server may just have woken it, and it waits for the core.
media::Peers IoLoop::peers() const {
  const std::int32_t mine = running_core();
  bool here = false;
  bool elsewhere = false;
  bool unknown = false;
  for (const auto& session : active_) {
    const media::Whereabouts client = session->connection().peer_whereabouts();
    if (client.core == unknown_core) {
      unknown = true;
    } else if (client.core == mine) {
      here = true;
    } else if (!client.asleep) {
      elsewhere = true;
    }
  }
  if (elsewhere) return here || unknown ? media::Peers::Both : media::Peers::Elsewhere;
  if (here) return media::Peers::Here;
  return unknown ? media::Peers::Unknown : media::Peers::Elsewhere;
}

bool IoLoop::poll_active() {
  bool something = false;
  // No thread would poll while a standby ran a handler, so a standby leaves handlers to workers.
  const auto starter = std::this_thread::get_id() == main_id_ ? Starter::Poller : Starter::Other;
  for (std::size_t at = 0; at < active_.size(); ++at) {
    ServerSession& session = *active_[at];
    std::shared_ptr<ServerCall> started;
    if (const auto packet = session.connection().receive()) {
      something = true;
      session.quiet_looks = 0;
      started = session.object()->take_and_start(active_[at], *packet, starter);
    }
    // A standby may disconnect the session while the handlers run: then `started` keeps the session
    // alive, or the copied pointer keeps the object alive.
    if (started) {
      run_handlers(*session.object(), std::move(started), starter);
    } else if (session.object()->ready()) {
      something = true;
      const auto object = session.object();
      run_handlers(*object, nullptr, starter);
    }
  }
  return something;
}

void IoLoop::retire_idle(TimePoint now) {
  const auto idle = [&](const std::shared_ptr<ServerSession>& session) {
    if (session->quiet_looks == 0) session->last_heard = now;
    session->quiet_looks = 1;
    if (session->gone.load()) return true;
    if (now - session->last_heard < stays_active) return false;
    if (!session->connection().prepare_to_sleep()) {
      session->connection().woke();
      return false;
    }
    session->active = false;
    return true;
  };
  active_.erase(std::remove_if(active_.begin(), active_.end(), idle), active_.end());
}

/// Prepares the connection of each active session for sleep. Returns false when a session must stay
/// active, because a packet has arrived.
bool IoLoop::prepare_all_to_sleep() {
  for (const auto& session : active_) {
    session->active = false;
    if (session->gone.load() || session->connection().prepare_to_sleep()) continue;
    session->connection().woke();
    part_if_lost(session);
    if (session->gone.load()) continue;
    session->active = true;
    still_active_.push_back(session);
  }
  active_.swap(still_active_);
  still_active_.clear();
  return active_.empty();
}

void IoLoop::activate(const std::shared_ptr<ServerSession>& session) {
  if (session->gone.load()) return;
  if (session->active) {
    // epoll reports a loss only once, so loss() must ask the kernel now
    session->connection().loss();
    return;
  }
  session->connection().woke();
  woken_ = media::Woken::ByAnswer;
  rang_at_ = std::max(rang_at_, session->connection().peer_whereabouts().rang_at);
  session->active = true;
  session->quiet_looks = 0;
  active_.push_back(session);
}

void IoLoop::take_events(int milliseconds) {
  std::array<epoll_event, 64> events{};
  int count = 0;
  {
    const MutexUnlock polled_by_others(polling_);
    count =
        epoll_wait(epoll_.descriptor, events.data(), static_cast<int>(events.size()), milliseconds);
  }
  for (int at = 0; at < count; ++at) {
    const std::uint64_t key = events[static_cast<std::size_t>(at)].data.u64;
    if (key == event_key) {
      event_.drain();
      add_endpoints();
      if (somebody_waits_.exchange(false)) accept_all();
      part_from_suspects();
    } else if ((key & endpoint_bit) != 0) {
      if (const auto& endpoint = endpoints_[key & ~endpoint_bit]) accept(*endpoint);
    } else if (const auto session = session_of(key)) {
      activate(session);
    }
  }
}

std::shared_ptr<ServerSession> IoLoop::session_of(std::uint64_t key) {
  const MutexLock list(list_mutex_);
  const auto found = sessions_.find(key);
  return found == sessions_.end() ? nullptr : found->second;
}

void IoLoop::accept(Endpoint& endpoint) {
  while (auto connection = endpoint.acceptor->accept()) {
    try {
      watch(std::make_shared<ServerSession>(std::move(connection), endpoint.object));
    } catch (const std::system_error& failed) {  // the client sees its connection closed
      log_warning("session", endpoint.object->name() + " turned a client away: " + failed.what());
    }
  }
  if (endpoint.acceptor->short_of_descriptors()) somebody_waits_.store(true);
  // Over a medium that loses packets, the packets of all clients arrive through this endpoint. So
  // each of their sessions may have one.
  const MutexLock list(list_mutex_);
  for (const auto& [key, session] : sessions_) {
    if (session->repeats() && session->object() == endpoint.object) activate(session);
  }
}

void IoLoop::accept_all() {
  for (const auto& endpoint : endpoints_) {
    if (endpoint) accept(*endpoint);
  }
}

void IoLoop::watch(const std::shared_ptr<ServerSession>& session) {
  const std::uint64_t key = next_key_++;
  for (const int descriptor : session->connection().descriptors()) add_descriptor(descriptor, key);
  session->last_heard = runtime_->clock().now();
  {
    const MutexLock list(list_mutex_);
    sessions_.emplace(key, session);
  }
  active_.push_back(session);
  log_debug("media", session->object()->name() + ": a connection over " +
                         std::string(session->connection().capabilities().name) +
                         " is open: " + session->connection().peer().description);
}

// Lost connections

void IoLoop::part_if_lost(const std::shared_ptr<ServerSession>& session) {
  if (session->gone.load()) return;
  if (session->connection().loss() == media::Loss::None) return;
  while (const auto packet = session->connection().receive()) {
    session->object()->take(session, *packet);
  }
  session->gone = true;
  log_debug("media", session->object()->name() +
                         ": a connection is lost: " + session->connection().loss_text());
  // `depart` treats a client that said goodbye as departed in order. A client that closes its
  // connection without a goodbye has given up its calls.
  session->object()->depart(session, ObjectHost::Departure::Lost);
  if (session->object()->ready())
    session->object()->run_ready(Starter::Other);  // starts the calls that the last packets queued
}

/// Disconnects the sessions whose connections the maintenance thread found lost, after reading
/// their last packets.
void IoLoop::part_from_suspects() {
  if (!suspects_.exchange(false)) return;
  drop_closed_endpoints();
  std::vector<std::shared_ptr<ServerSession>> gone;
  const MutexLock list(list_mutex_);
  for (auto at = sessions_.begin(); at != sessions_.end();) {
    part_if_lost(at->second);
    if (!at->second->gone.load()) {
      ++at;
      continue;
    }
    gone.push_back(at->second);
    at = sessions_.erase(at);
  }
}

void IoLoop::drop_closed_endpoints() {
  for (auto& endpoint : endpoints_) {
    if (endpoint && endpoint->object->closed()) endpoint.reset();
  }
}

void IoLoop::await_signs_of_life() {
  const MutexLock list(list_mutex_);
  for (const auto& [key, session] : sessions_) session->object()->await_sign_of_life(*session);
}

TimePoint IoLoop::on_tick(TimePoint now) {
  const std::uint64_t handler = handler_turn_.load();
  if (handler % 2 == 1 && handler == handler_seen_) {
    const MutexLock called(standby_mutex_);
    standby_wanted_ = true;
    standby_called_.notify_one();
    event_.notify();  // the standby may still sleep in epoll_wait since its last turn
  }
  handler_seen_ = handler;

  std::vector<std::shared_ptr<ServerSession>> sessions;
  {
    const MutexLock list(list_mutex_);
    for (const auto& [key, session] : sessions_) sessions.push_back(session);
  }
  const bool beat = now >= next_beat_;
  if (beat) next_beat_ = now + runtime_->options().heartbeat;
  bool suspects = false;
  for (const auto& session : sessions) {
    session->flush();
    if (beat) session->connection().beat();
    if (session->object()->check_liveness(session)) {
      session->gone = true;
      session->object()->depart(session, ObjectHost::Departure::Lost);
    }
    suspects = suspects || session->gone.load() ||
               (beat && session->connection().loss() != media::Loss::None);
  }
  if (suspects) suspects_.store(true);
  if (suspects || (beat && somebody_waits_.load())) event_.notify();
  return now + (handler % 2 == 1 ? Maintenance::tick : Maintenance::calm_tick);
}

void IoLoop::withdraw(const ObjectHost& object) {
  {
    const MutexLock list(list_mutex_);
    for (const auto& [key, session] : sessions_) {
      if (session->object().get() == &object) session->gone = true;
    }
  }
  suspects_.store(true);
  event_.notify();
}

void IoLoop::end() {
  if (ended_.exchange(true)) return;
  event_.notify();
  {
    const MutexLock called(standby_mutex_);
    standby_called_.notify_one();
  }
  main_.join();
  standby_.join();
  const MutexLock polling(polling_);
  for (const auto& endpoint : endpoints_) {
    while (endpoint && endpoint->acceptor->accept()) {  // new clients see their connection close
    }
  }
  decltype(sessions_) sessions;
  {
    const MutexLock list(list_mutex_);
    sessions.swap(sessions_);
    new_endpoints_.clear();
  }
  for (const auto& [key, session] : sessions) {
    // Over a medium that cannot tell which packets were read, only an answer tells the client that
    // a call did not start.
    while (session->repeats() && !session->gone.load()) {
      const auto packet = session->connection().receive();
      if (!packet) break;
      session->object()->take(session, *packet);
    }
    session->object()->depart(session, ObjectHost::Departure::InOrder);
    session->flush();
    wire::PacketHeader header;
    header.kind = wire::PacketKind::Goodbye;
    session->send(header, {});
  }
  active_.clear();
  endpoints_.clear();
}

}  // namespace gecos::session
