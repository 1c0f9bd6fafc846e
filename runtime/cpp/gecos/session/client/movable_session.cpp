#include "gecos/session/client/movable_session.hpp"

#include <algorithm>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/client/context.hpp"

namespace gecos::session {
namespace {

constexpr Duration between_looks = std::chrono::milliseconds(100);

bool has_ended(const ClientConnection& session) { return session.lost() || session.closed(); }

}  // namespace

std::shared_ptr<ClientSession> with_failover(Context& lab,
                                             std::shared_ptr<ClientConnection> session,
                                             const InterfaceDescription& wanted) {
  const bool declared = wanted.quality.on_degraded == qos::OnDegraded::Failover;
  if (!declared || session->line().bound <= Duration{}) return session;
  const CreateOptions& options = session->failover().connect_target().options;
  const bool chosen = options.medium || options.in || options.out;
  auto movable = std::make_shared<MovableSession>(
      lab, std::move(session), chosen ? "this program has chosen the medium" : "");
  lab.runtime()->maintenance().add(movable);
  return movable;
}

MovableSession::MovableSession(Context& lab, std::shared_ptr<ClientConnection> session,
                               std::string must_stay)
    : object_name_(session->object_name()),
      interface_name_(session->interface_name()),
      must_stay_(std::move(must_stay)),
      failover_(lab.failover()),
      current_(std::move(session)) {}

std::shared_ptr<ClientConnection> MovableSession::current() const {
  const MutexLock lock(mutex_);
  return current_;
}

std::shared_ptr<CommandCore> MovableSession::call(const OperationDescription& operation,
                                                  std::size_t size,
                                                  FunctionRef<void(wire::Encoder&)> encode,
                                                  const CallOptions& options) {
  if (!StatusUse::concerns(operation.code)) {
    return current()->call(operation, size, encode, options);
  }
  std::shared_ptr<ClientConnection> session;
  {
    const MutexLock lock(mutex_);
    status_.begin();  // from now on the session does not move to another medium
    session = current_;
  }
  auto command = session->call(operation, size, encode, options);
  const MutexLock lock(mutex_);
  status_.issued(operation.code, command);
  return command;
}

std::shared_ptr<CommandCore> MovableSession::refuse(const OperationDescription& operation,
                                                    Failure failure) {
  return current()->refuse(operation, std::move(failure));
}

tl::expected<std::shared_ptr<StreamCore>, Failure> MovableSession::subscribe(
    const StreamDescription& stream) {
  const MutexLock subscribing(subscribing_);
  const auto session = current();
  // If the session stays on its medium, its streams may come over a second session, the 'in'
  // channel.
  if (!must_stay_.empty()) return session->subscribe(stream);
  if (auto refused = session->refusal(stream.code, stream.name, qos::Traffic::Samples)) {
    return tl::unexpected(std::move(*refused));
  }
  auto opened = session->subscriptions().subscribe(stream);
  if (!opened) return tl::unexpected(std::move(opened.error()));
  auto movable = std::make_shared<MovableStream>(shared_from_this(), session->runtime(), stream,
                                                 std::move(*opened));
  std::erase_if(streams_, [](const auto& known) { return known.expired(); });
  streams_.push_back(movable);
  return movable;
}

tl::expected<std::shared_ptr<WriterCore>, Failure> MovableSession::open_writer(
    const InwardDescription& stream) {
  // The session must not move to another medium before it knows the new writer. This mutex prevents
  // the move.
  const MutexLock subscribing(subscribing_);
  auto writer = current()->open_writer(stream);
  const MutexLock lock(mutex_);
  if (writer) writers_.push_back(*writer);
  return writer;
}

const media::Capabilities& MovableSession::capabilities() const {
  const MutexLock lock(mutex_);
  const media::Capabilities& present = current_->capabilities();
  return capabilities_.try_emplace(present.name, present).first->second;
}

std::uint64_t MovableSession::lease_acquired(std::uint64_t epoch) {
  return current()->lease_acquired(epoch);
}

std::uint64_t MovableSession::issued() {
  const MutexLock lock(mutex_);
  return issued_before_ + current_->issued();
}

// The functions below are about the state of the connection.

LineState MovableSession::line() const {
  const MutexLock lock(mutex_);
  return line_now();
}

LineState MovableSession::line_now() const {
  LineState line = current_->line();
  const bool reported_last = !report_.why.empty() && line.changes == report_.at;
  line.changes += report_.earlier;
  if (!reported_last) return line;
  line.moved_from = report_.moved_from;
  line.why = report_.why;
  return line;
}

LineState MovableSession::await_line_change(std::uint64_t changes, TimePoint deadline) const {
  for (;;) {
    std::shared_ptr<ClientConnection> session;
    LineState line;
    std::uint64_t earlier = 0;
    {
      const MutexLock lock(mutex_);
      session = current_;
      line = line_now();
      earlier = report_.earlier;
    }
    const TimePoint now = std::chrono::steady_clock::now();
    if (line.changes > changes || has_ended(*session) || now >= deadline) return line;
    session->await_line_change(changes - earlier, std::min(deadline, now + between_looks));
  }
}

// The functions below move the session to another medium.

std::string MovableSession::why_stay() {
  if (!must_stay_.empty()) return must_stay_;
  if (status_.in_use()) return "this program has a status or asks for one";
  std::erase_if(writers_, [](const auto& known) { return known.expired(); });
  return writers_.empty() ? "" : "this program writes an inward stream";
}

/// Reports that the session stays on its medium. Returns the text of the report.
std::string MovableSession::report_stay(const std::string& why) {
  const LineState line = current_->line();
  report_ = {report_.earlier + 1, line.changes, "",
             object_name_ + " stays on " + line.medium + ": " + why};
  return report_.why;
}

NextTick MovableSession::on_tick(TimePoint now) {
  using Act = qos::FailoverPlan::Act;
  Act act = Act::None;
  std::string text;
  std::shared_ptr<ClientConnection> session;
  {
    const MutexLock lock(mutex_);
    session = current_;
    const std::string why = why_stay();
    const bool degraded = session->line().degraded && !has_ended(*session);
    act = plan_.look(degraded, !why.empty(), now);
    if (act == Act::ReportStay) text = report_stay(why);
  }
  if (act == Act::ReportStay) log(session->line_probe().log_level(), "client", text);
  if (act != Act::Search) return now + between_looks;
  const auto job = [weak = weak_from_this()](Context& lab) {
    if (const auto self = weak.lock()) self->search(lab);
  };
  if (const auto ran = failover_->run_soon(job); !ran) stay(ran.error());
  return now + between_looks;
}

void MovableSession::search(Context& lab) {
  // After a failover, `slow` is often the last reference to the old session. It is declared before
  // the lock, so that the session ends after the mutex is released, because the end of a session
  // takes a while.
  const auto slow = current();
  const auto found = open_elsewhere(lab, *slow);
  if (!found) return stay(found.error().reason);
  const MutexLock subscribing(subscribing_);
  auto resumed = resume_streams(**found);
  if (!resumed) return stay(resumed.error().text);
  if (!move_to(*found)) return;
  for (auto& [stream, core] : *resumed) stream->go_on_in(std::move(core));
}

void MovableSession::stay(const std::string& why) {
  std::string text;
  LogLevel level{};
  {
    const MutexLock lock(mutex_);
    if (!plan_.found_none(current_->runtime().clock().now())) return;
    text = report_stay(why);
    level = current_->line_probe().log_level();
  }
  log(level, "client", text);
}

/// Subscribes to all open streams over the new connection `found`. Fails when one of these streams
/// cannot be opened over it.
tl::expected<std::vector<MovableSession::Resumed>, Failure> MovableSession::resume_streams(
    ClientConnection& found) {
  std::vector<Resumed> resumed;
  for (const auto& known : streams_) {
    auto stream = known.lock();
    if (stream == nullptr) continue;
    const StreamDescription& about = stream->description();
    if (auto refused = found.refusal(about.code, about.name, qos::Traffic::Samples)) {
      return tl::unexpected(std::move(*refused));
    }
    auto core = found.subscriptions().subscribe(about, stream->core().get());
    if (!core) return tl::unexpected(std::move(core.error()));
    resumed.push_back({std::move(stream), std::move(*core)});
  }
  return resumed;
}

/// Makes `found` the present session and reports the failover. If the session must stay on its
/// medium or need not move any more, does nothing and returns false.
bool MovableSession::move_to(const std::shared_ptr<ClientConnection>& found) {
  std::string text;
  LogLevel level{};
  {
    const MutexLock lock(mutex_);
    const LineState slow = current_->line();
    if (!slow.degraded || has_ended(*current_) || !why_stay().empty()) {
      plan_.dropped();
      return false;
    }
    text = object_name_ + " has moved from " + slow.medium + " to " + found->line().medium + ": " +
           slow.why;
    level = found->line_probe().log_level();
    issued_before_ += current_->issued();
    current_ = found;  // the caller keeps the session that was left, until the mutex is released
    report_ = {report_.earlier + slow.changes + 1, 0, slow.medium, text};
    plan_.moved();
  }
  log(level, "client", text);
  return true;
}

}  // namespace gecos::session
