#include "gecos/session/server/io_loop.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <system_error>

#include "gecos/base/log.hpp"
#include "gecos/base/thread.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {
namespace {

constexpr std::uint64_t event_key = 0;
constexpr std::uint64_t endpoint_bit = std::uint64_t{1} << 63;
/// Number of turns of the loop between two checks for epoll events. A turn that finds a packet
/// takes longer, so it counts as `busy_turn` turns; otherwise a client whose connection sleeps
/// would wait long.
constexpr unsigned turns_between_events = 8192;
constexpr unsigned busy_turn = 128;
/// Time between two checks whether the clients are still admitted. A revocation must take effect
/// within 5 s.
constexpr Duration review_every = std::chrono::seconds(1);

/// Ends the streams of a client that is not admitted any more, and tells the client the reason.
void exclude(ServerSession& session, const std::string& why) {
  ObjectHost& object = *session.object();
  session.sender().with_connection(
      [&](media::Connection& connection) { object.streams().exclude(connection); });
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Goodbye;
  header.flags = revokes;
  session.send(header, goodbye_body("revoked: " + why));
  log_warning("session", object.name() +
                             ": a session was ended, because its client is not admitted any "
                             "more: " +
                             why);
}

}  // namespace

IoLoop::IoLoop(std::shared_ptr<Runtime> runtime, std::shared_ptr<AccessControl> access)
    : runtime_(std::move(runtime)), access_(std::move(access)), spin_(system_clock()) {
  epoll_.add(event_.descriptor(), event_key);
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
    const MutexLock lock(new_endpoints_mutex_);
    new_endpoints_.push_back(
        std::make_unique<Endpoint>(Endpoint{std::move(object), std::move(acceptor)}));
  }
  event_.notify();
}

void IoLoop::add_endpoints() {
  std::vector<std::unique_ptr<Endpoint>> opened;
  {
    const MutexLock lock(new_endpoints_mutex_);
    opened.swap(new_endpoints_);
  }
  for (auto& endpoint : opened) {
    const auto key = endpoint_bit | endpoints_.size();
    for (const int descriptor : endpoint->acceptor->descriptors()) epoll_.add(descriptor, key);
    endpoints_.push_back(std::move(endpoint));
    accept(*endpoints_.back());
  }
}

// The functions below poll the connections.

void IoLoop::run() {
  const MutexLock polling(polling_);
  main_id_ = std::this_thread::get_id();
  spin_.begin();
  while (!ended_.load()) turn();
  event_.notify();  // wakes the standby thread, which may sleep on the same events
}

void IoLoop::run_standby() {
  while (standby_call_.wait()) {
    const MutexLock polling(polling_);
    while (!ended_.load() && main_is_inside()) turn();
    event_.notify();  // the standby thread may have drained events for which the main thread waits
  }
}

void IoLoop::run_handlers(ObjectHost& object, std::shared_ptr<ServerCall> started,
                          Starter starter) {
  const bool main = starter == Starter::Poller;
  const auto turn = handler_turn_.load(std::memory_order_relaxed);
  if (main) {
    handled_.store(&object, std::memory_order_relaxed);
    handler_turn_.store(turn + 1, std::memory_order_release);
  }
  polling_.unlock();
  object.run_ready(starter, std::move(started));
  if (main) handler_turn_.store(turn + 2, std::memory_order_release);
  if (polling_.try_lock()) return;
  event_.notify();  // the standby thread polls and may sleep: wake it, so that it releases polling_
  polling_.lock();
}

void IoLoop::turn() {
  const bool busy = poll_active();
  turns_ += busy ? busy_turn : 1;
  if (turns_ >= turns_between_events) {
    turns_ = 0;
    active_.retire_idle(runtime_->clock().now());
    take_events(0);
  }
  if (busy) spin_.begin();
  if (busy || (!active_.empty() && spin_.again([this] {
        polling_.assert_held();
        return active_.peers();
      }))) {
    return;
  }
  const bool all_sleep = active_.put_to_sleep([this](const auto& session) {
    polling_.assert_held();
    part_if_lost(session);
  });
  // The call of take_events() above may have consumed the event that announces `ended_`, so
  // `ended_` is checked again.
  if (all_sleep && !ended_.load()) {
    wake_ = {};
    take_events(-1);
    spin_.woke(wake_.rang_at, wake_.by);
  }
  spin_.begin();
}

bool IoLoop::poll_active() {
  bool something = false;
  // If the standby thread ran a handler, no thread would poll meanwhile. Therefore the standby
  // thread leaves handlers to worker threads.
  const auto starter = std::this_thread::get_id() == main_id_ ? Starter::Poller : Starter::Other;
  for (std::size_t at = 0; at < active_.size(); ++at) {
    ServerSession& session = *active_[at];
    std::shared_ptr<ServerCall> started;
    if (const auto packet = session.connection().receive()) {
      something = true;
      session.polled.quiet_looks = 0;
      started = session.object()->take_and_start(active_[at], *packet, starter);
    }
    // The standby thread may disconnect the session while the handlers run. The variable `started`
    // or `object` then keeps alive what the handlers use.
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

void IoLoop::activate(const std::shared_ptr<ServerSession>& session) {
  if (session->gone.load()) return;
  if (!active_.wake(session)) {
    // epoll reports a loss of the connection only once, so loss() must check for a loss now.
    session->connection().loss();
    return;
  }
  wake_.by = media::Woken::ByAnswer;
  wake_.rang_at = std::max(wake_.rang_at, session->connection().peer_whereabouts().rang_at);
}

void IoLoop::take_events(int milliseconds) {
  // The packets that an acceptor receives make the descriptors of their connections readable. So
  // after an event of an acceptor, handle_events() is called again, without a wait.
  if (handle_events(milliseconds)) handle_events(0);
}

bool IoLoop::handle_events(int milliseconds) {
  std::array<epoll_event, 64> room{};
  std::span<const epoll_event> events;
  const bool sleeps = milliseconds < 0 && std::this_thread::get_id() == main_id_;
  {
    const MutexUnlock polled_by_others(polling_);
    if (sleeps) sleep_.begin();
    events = epoll_.wait(room, milliseconds);
    if (sleeps) sleep_.end();
  }
  bool accepted = false;
  for (const auto& event : events) {
    const std::uint64_t key = event.data.u64;
    if (key == event_key) {
      event_.drain();
      add_endpoints();
      if (somebody_waits_.exchange(false)) accept_all();
      part_from_suspects();
    } else if ((key & endpoint_bit) != 0) {
      accepted = true;
      if (const auto& endpoint = endpoints_[key & ~endpoint_bit]) accept(*endpoint);
    } else if (const auto session = sessions_.find(key)) {
      activate(session);
    }
  }
  return accepted;
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
}

void IoLoop::accept_all() {
  for (const auto& endpoint : endpoints_) {
    if (endpoint) accept(*endpoint);
  }
}

void IoLoop::watch(const std::shared_ptr<ServerSession>& session) {
  const std::uint64_t key = sessions_.new_key();
  for (const int descriptor : session->connection().descriptors()) epoll_.add(descriptor, key);
  session->polled.last_heard = runtime_->clock().now();
  sessions_.add(key, session);
  active_.add(session);
  log_debug("media", session->object()->name() + ": a connection over " +
                         std::string(session->connection().capabilities().name) +
                         " is open: " + session->connection().peer().description);
}

// The functions below are about lost connections.

void IoLoop::part_if_lost(const std::shared_ptr<ServerSession>& session) {
  if (session->gone.load()) return;
  if (session->connection().loss() == media::Loss::None) return;
  while (const auto packet = session->connection().receive()) {
    session->object()->take(session, *packet);
  }
  session->gone = true;
  log_debug("media", session->object()->name() +
                         ": a connection is lost: " + session->connection().loss_text());
  // If the client has said goodbye, `depart` treats the loss of the connection as an end in order.
  // A client that closes its connection without a goodbye has given up its calls.
  session->object()->depart(session, ObjectHost::Departure::Lost);
  if (session->object()->ready())
    session->object()->run_ready(Starter::Other);  // starts calls that the last packets queued
}

/// Reads the last packets of the sessions whose connections are lost, and disconnects these
/// sessions.
void IoLoop::part_from_suspects() {
  if (!suspects_.exchange(false)) return;
  drop_closed_endpoints();
  sessions_.remove_if([this](const auto& session) {
    polling_.assert_held();
    part_if_lost(session);
    return session->gone.load();
  });
}

void IoLoop::drop_closed_endpoints() {
  for (auto& endpoint : endpoints_) {
    if (endpoint && endpoint->object->closed()) endpoint.reset();
  }
}

void IoLoop::await_signs_of_life() {
  sessions_.for_each([](const auto& session) { session->object()->await_sign_of_life(*session); });
}

TimePoint IoLoop::on_tick(TimePoint now) {
  sleep_.drain();
  const std::uint64_t handler = handler_turn_.load();
  if (handler % 2 == 1 && handler == handler_seen_) {
    standby_call_.call();
    event_.notify();  // the standby thread may still sleep in epoll_wait since its last turn
  }
  handler_seen_ = handler;

  const bool revoked = end_revoked(now);
  // When a session is excluded from streams, these streams move to new memory. The next heartbeat
  // tells the remaining readers where the new memory is, so the heartbeat is sent at once.
  const Duration period = std::min(runtime_->options().heartbeat, heartbeat_period);
  const bool beat = heartbeats_.due(now, period) || revoked;
  bool suspects = false;
  const bool at_rest = handler % 2 == 0 && sleep_.count_on();
  TimePoint next_look = at_rest ? TimePoint::max() : now + Maintenance::calm_tick;
  for (const auto& session : sessions_.all()) {
    const bool sent = session->sender().flush();
    // Heartbeats are noted even while the server is busy. Otherwise the first look for a heartbeat,
    // after the server is no longer busy, could come too late.
    const TimePoint look = next_look_at(*session, sent, now);
    if (at_rest) next_look = std::min(next_look, look);
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
  return handler % 2 == 1 ? now + Maintenance::tick : heartbeats_.next_tick(next_look);
}

/// Returns the time at which the maintenance thread must check `session` again while the polling
/// thread sleeps. `sent`: true if no packet waits to be sent to the client of `session`.
TimePoint IoLoop::next_look_at(ServerSession& session, bool sent, TimePoint now) const {
  if (session.repeats() || !sent) return now + Maintenance::calm_tick;
  return session.looks.look(session.connection().beats_seen(), now);
}

bool IoLoop::end_revoked(TimePoint now) {
  bool any = false;
  for (const auto& [key_session, why] : keys_.take()) {
    if (const auto session = key_session.lock()) any = revoke(session, why) || any;
  }
  if (now < next_review_) return any;
  next_review_ = now + review_every;
  const auto sessions = sessions_.all();
  for (const auto& session : sessions) {
    const auto judgement =
        access_->judge_again(session->object()->name(), session->connection().peer());
    // If the client became a visitor in the same session, the objects that it has registered would
    // stay registered. Therefore the session ends.
    const bool narrowed = judgement.visitor && session->visit.is_full();
    const std::string why = narrowed ? "the lab file no longer names user " + judgement.who.user +
                                           " of host " + judgement.who.host +
                                           "; connect again as a visitor"
                                     : judgement.text;
    if (!judgement.admitted || narrowed) any = revoke(session, why) || any;
    if (judgement.admitted && !judgement.visitor && session->visit.visitor() != nullptr) {
      session->visit.widen();
    }
  }
  keys_.begin(sessions);
  return any;
}

bool IoLoop::revoke(const std::shared_ptr<ServerSession>& session, const std::string& why) {
  if (session->gone.exchange(true)) return false;
  session->object()->depart(session, ObjectHost::Departure::Lost, "was revoked: " + why);
  exclude(*session, why);
  return true;
}

void IoLoop::withdraw(ObjectHost& object) {
  // A polling thread holds `polling_` from the packet of a call until `main_is_inside`. It also
  // holds `polling_` while it removes lost sessions. So after these sessions are removed, no
  // further handler of `object` begins.
  const auto may_call_servant = [&] {
    bool connected = false;
    sessions_.for_each(
        [&](const auto& session) { connected = connected || session->object().get() == &object; });
    return connected || (main_is_inside() && handled_.load() == &object);
  };
  do {
    for (const auto& session : sessions_.all()) {
      if (session->object().get() != &object || session->gone.exchange(true)) continue;
      object.depart(session, ObjectHost::Departure::Lost);
    }
    suspects_.store(true);
    event_.notify();
    std::this_thread::sleep_for(Maintenance::tick / 10);
  } while (!ended_.load() && may_call_servant());
}

void IoLoop::end() {
  if (ended_.exchange(true)) return;
  event_.notify();
  standby_call_.end();
  main_.join();
  standby_.join();
  const MutexLock polling(polling_);
  for (const auto& endpoint : endpoints_) {
    while (endpoint && endpoint->acceptor->accept()) {  // new clients see their connection close
    }
  }
  {
    const MutexLock lock(new_endpoints_mutex_);
    new_endpoints_.clear();
  }
  for (const auto& session : sessions_.remove_if([](const auto&) { return true; })) {
    // The object refuses the calls that the server has not read before it ends. Over a medium that
    // cannot tell the client which packets were read, only a reply to each call tells the client
    // that the call did not start.
    while (session->repeats() && !session->gone.load()) {
      const auto packet = session->connection().receive();
      if (!packet) break;
      session->object()->take(session, *packet);
    }
    session->object()->depart(session, ObjectHost::Departure::InOrder);
    session->sender().flush();
    wire::PacketHeader header;
    header.kind = wire::PacketKind::Goodbye;
    session->send(header, {});
  }
  active_.clear();
  endpoints_.clear();
}

}  // namespace gecos::session
