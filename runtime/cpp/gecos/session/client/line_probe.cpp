#include "gecos/session/client/line_probe.hpp"

#include <algorithm>

#include "gecos/base/log.hpp"
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/qos/match.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/own_call.hpp"

namespace gecos::session {
namespace {

/// The longest time that the probe's clock counts between two ticks. A longer time means that this
/// process was suspended, which says nothing about the connection.
constexpr Duration longest_step = std::chrono::milliseconds(300);

}  // namespace

LineProbe::LineProbe(ClientConnection& session)
    : session_(session), clock_(session.runtime().clock().now(), longest_step) {
  const MutexLock lock(mutex_);
  state_.medium = session.capabilities().name;
}

LineProbe::~LineProbe() = default;

void LineProbe::bound_by(Duration bound, const InterfaceDescription& wanted, bool simulated) {
  if (bound <= Duration{}) return;
  watch_.emplace(bound);
  on_degraded_ = wanted.quality.on_degraded;
  simulated_ = simulated;
  const MutexLock lock(mutex_);
  state_.bound = bound;
}

std::optional<qos::LatencySample::Latency> LineProbe::measure(Duration longest) {
  const auto now = [] { return TimePoint(std::chrono::steady_clock::now()); };
  qos::LatencySample sample(now(), longest);
  while (sample.wants_another(now())) {
    const TimePoint sent = now();
    pings_.fetch_add(1, std::memory_order_relaxed);
    const auto ping = own_call(session_, GecosObjectInterface::ping);
    if (!ping->wait_until(sample.gives_up())) break;
    if (ping->progress().detail != Detail::Done) return std::nullopt;
    sample.answered(now() - sent);
  }
  const auto found = sample.latency(now());
  const MutexLock lock(mutex_);
  state_.round_trip = found.round_trip;
  return found;
}

void LineProbe::on_tick(TimePoint now) {
  if (!watch_) return;
  const TimePoint judged = clock_.advance(now);
  if (ping_ && ping_->terminal()) take_answer(judged);
  note(watch_->look(judged));
  if (watch_->probe_due(judged) && !session_.lost() && !session_.unreachable()) send(judged);
}

void LineProbe::send(TimePoint now) {
  // The ping has no reference to the session, so that it does not keep the session of a destroyed
  // proxy alive.
  auto ping = std::make_shared<PendingCommand>(nullptr, GecosObjectInterface::ping);
  ping->observe();
  ping->timed = true;
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Call;
  header.code = GecosObjectInterface::ping.code;
  sent_ = session_.runtime().clock().now();
  CallSender& calls = session_.calls();
  if (!calls.send(
          header, calls.most_open(true), 0, [](wire::Encoder&) {}, ping, nullptr)) {
    return watch_->failed(now);
  }
  pings_.fetch_add(1, std::memory_order_relaxed);
  ping_ = std::move(ping);
  watch_->sent(now);
  session_.reader().add_watcher();
}

void LineProbe::take_answer(TimePoint now) {
  session_.reader().remove_watcher();
  const auto ping = std::move(ping_);
  if (ping->progress().detail != Detail::Done) return watch_->failed(now);
  note(watch_->answered(ping->answered - sent_, now));
}

void LineProbe::note(qos::LatencyWatch::Change change) {
  std::string text;
  {
    const MutexLock lock(mutex_);
    // Until the server answers the first ping of on_tick(), `round_trip` keeps the value that
    // measure() found.
    if (const auto last = watch_->round_trip()) state_.round_trip = last;
    if (change == qos::LatencyWatch::Change::None) return;
    state_.degraded = watch_->degraded();
    ++state_.changes;
    text = session_.object_name() + " over " + state_.medium + ": the round trip took " +
           qos::with_unit(*state_.round_trip);
    if (state_.degraded) {
      text += "; for one second it has exceeded latency=";
    } else {
      text += ", again within latency=";
    }
    text += qos::with_unit(state_.bound);
    state_.why = text;
  }
  changed_.notify_all();
  log(log_level(), "client", text);
  if (change == qos::LatencyWatch::Change::Degraded && on_degraded_ == qos::OnDegraded::Fail) {
    session_.give_up(text);
  }
}

LogLevel LineProbe::log_level() const { return simulated_ ? LogLevel::Info : LogLevel::Warning; }

LineState LineProbe::state() const {
  const MutexLock lock(mutex_);
  return state_;
}

LineState LineProbe::await_change(std::uint64_t changes, TimePoint deadline) const {
  // Nothing notifies this object when the session ends, so this object checks for the end.
  constexpr Duration between_looks = std::chrono::milliseconds(100);
  MutexLock lock(mutex_);
  while (state_.changes <= changes && !session_.lost() && !session_.closed()) {
    const TimePoint now = std::chrono::steady_clock::now();
    if (now >= deadline) break;
    changed_.wait_until(lock, std::min(deadline, now + between_looks));
  }
  return state_;
}

}  // namespace gecos::session
