#include "gecos/session/client/session_failover.hpp"

#include <algorithm>

#include "gecos/base/recycling_allocator.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/start_words.hpp"

namespace gecos::session {

void SessionFailover::set(std::shared_ptr<Failover> failover, ConnectTarget target) {
  failover_ = std::move(failover);
  connect_target_ = std::make_unique<const ConnectTarget>(std::move(target));
}

std::shared_ptr<CommandCore> SessionFailover::call(const OperationDescription& operation,
                                                   std::size_t size,
                                                   FunctionRef<void(wire::Encoder&)> encode,
                                                   const CallOptions& options) {
  if (session_.lost()) {
    if (const auto next = successor()) return next->call(operation, size, encode, options);
  }
  auto command = make_recycled<PendingCommand>(session_.shared_from_this(), operation);
  command->again = std::make_unique<PendingCommand::Again>();
  auto& again = *command->again;
  command->marked_words = marked_words(operation);
  again.code = operation.code;
  again.name = operation.name;
  again.arguments.resize(size);
  wire::Encoder to(again.arguments);
  encode(to);
  const Clock& clock = session_.runtime().clock();
  const Duration within = session_.deadline_of(operation, options);
  if (within.count() > 0) {
    // A deadline that is centuries away counts as no deadline.
    const TimePoint now = clock.since_boot();
    if (within < TimePoint::max() - now) again.deadline = now + within;
  }

  auto sent = send(command);
  if (!sent && sent.error() == media::SendProblem::Full) {
    session_.reader().poll_once();
    sent = send(command);
  }
  if (sent) return command;
  Failure failure = session_.calls().not_sent(operation.name, size, sent.error());
  if (sent.error() != media::SendProblem::Lost) {
    command->fail(std::move(failure));
    return command;
  }
  command->detach();
  const TimePoint give_up = clock.now() + session_.runtime().options().grace;
  failover_->take(session_.shared_from_this(), {{command, std::move(failure), give_up}});
  return command;
}

tl::expected<void, media::SendProblem> SessionFailover::send(
    const std::shared_ptr<PendingCommand>& command) {
  const auto& again = *command->again;
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Call;
  header.code = again.code;
  if (again.deadline != TimePoint::max()) {
    header.deadline =
        std::max(again.deadline - session_.runtime().clock().since_boot(), Duration{1});
  }
  // The server process that got the first attempt may know the outcome of the call, so the packet
  // names the session and the counter of the first attempt. Any other server process takes the
  // packet for a new call.
  const bool known = again.sessions != 0 && command->incarnation == session_.welcome().incarnation;
  if (known) header.flags = sent_again;
  CallSender& calls = session_.calls();
  return calls.send(
      header, calls.most_open(is_builtin(again.code)),
      again.arguments.size() + (known ? sent_before_size : 0),
      [&](wire::Encoder& to) {
        if (known) SentBefore{command->session_id, command->counter}.encode(to);
        to.put_bytes(again.arguments);
      },
      command, session_.shared_from_this());
}

tl::expected<bool, Failure> SessionFailover::send_again(
    const std::shared_ptr<PendingCommand>& command) {
  const auto& again = *command->again;
  if (auto refused = session_.refusal(again.code, again.name)) {
    return tl::unexpected(std::move(*refused));
  }
  const auto sent = send(command);
  if (sent) return true;
  if (sent.error() != media::SendProblem::TooLarge) return false;
  return tl::unexpected(
      session_.calls().not_sent(again.name, again.arguments.size(), sent.error()));
}

/// Each session that was replaced points to its successor. Returns the first of the successors of
/// this session that is not lost; null when there is none. Removes the lost successors before that
/// session.
std::shared_ptr<ClientConnection> SessionFailover::successor() {
  const auto first = next();
  auto last = first;
  while (last && last->lost()) last = last->failover().next();
  if (last == first) return last;
  auto between = first;  // destroyed after the mutex is released
  const MutexLock lock(mutex_);
  if (successor_ == first) successor_ = last;
  return last;
}

std::shared_ptr<ClientConnection> SessionFailover::next() {
  const MutexLock lock(mutex_);
  return successor_;
}

void SessionFailover::set_successor(std::shared_ptr<ClientConnection> successor) {
  const MutexLock lock(mutex_);
  successor_.swap(successor);
}

void SessionFailover::look_for_another() {
  if (failover_ && session_.calls().has_repeatable()) {
    failover_->look_for_another(session_.shared_from_this());
  }
}

std::vector<PendingFailover> SessionFailover::detach_repeatable() {
  auto pending = session_.calls().detach_repeatable(
      Ending::Silent, "the server of " + session_.object_name() + " (" +
                          session_.connection().peer().description + ") fell silent");
  if (!pending.empty()) session_.reader().wake_all();
  return pending;
}

void SessionFailover::take_over(std::vector<PendingFailover> commands) {
  if (!commands.empty()) failover_->take(session_.shared_from_this(), std::move(commands));
}

}  // namespace gecos::session
