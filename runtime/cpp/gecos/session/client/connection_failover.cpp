// The client side of failover: @idempotent readings of a lost session continue in another one.
#include <algorithm>

#include "gecos/base/recycling_allocator.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/start_words.hpp"

namespace gecos::session {

void ClientConnection::set_failover(std::shared_ptr<Failover> failover, ConnectTarget target) {
  failover_ = std::move(failover);
  connect_target_ = std::make_unique<const ConnectTarget>(std::move(target));
}

/// Returns the last session of the chain of successors. Drops the lost sessions before it.
std::shared_ptr<ClientConnection> ClientConnection::successor() {
  const auto first = next();
  auto last = first;
  while (last && last->lost()) last = last->next();
  if (last == first) return last;
  auto between = first;  // destroyed after the mutex is released
  const MutexLock lock(mutex_);
  if (successor_ == first) successor_ = last;
  return last;
}

std::shared_ptr<ClientConnection> ClientConnection::next() {
  const MutexLock lock(mutex_);
  return successor_;
}

void ClientConnection::set_successor(std::shared_ptr<ClientConnection> successor) {
  const MutexLock lock(mutex_);
  successor_.swap(successor);
}

std::shared_ptr<CommandCore> ClientConnection::call_repeatable(
    const OperationDescription& operation, std::size_t size,
    FunctionRef<void(wire::Encoder&)> encode, const CallOptions& options) {
  if (lost()) {
    if (const auto next = successor()) return next->call(operation, size, encode, options);
  }
  auto command = make_recycled<PendingCommand>(shared_from_this(), operation);
  command->again = std::make_unique<PendingCommand::Again>();
  auto& again = *command->again;
  command->marked_words = marked_words(operation);
  again.code = operation.code;
  again.name = operation.name;
  again.arguments.resize(size);
  wire::Encoder to(again.arguments);
  encode(to);
  const Duration within = options.deadline.value_or(operation.quality.deadline);
  if (within.count() > 0) {
    // a deadline that is centuries away counts as none
    const TimePoint now = runtime_->clock().since_boot();
    if (within < TimePoint::max() - now) again.deadline = now + within;
  }

  auto sent = send_repeatable(command);
  if (!sent && sent.error() == media::SendProblem::Full) {
    poll_once();
    sent = send_repeatable(command);
  }
  if (sent) return command;
  Failure failure = calls_.not_sent(operation.name, size, sent.error());
  if (sent.error() != media::SendProblem::Lost) {
    command->fail(std::move(failure));
    return command;
  }
  command->detach();
  const TimePoint give_up = runtime_->clock().now() + runtime_->options().grace;
  failover_->take(shared_from_this(), {{command, std::move(failure), give_up}});
  return command;
}

tl::expected<void, media::SendProblem> ClientConnection::send_repeatable(
    const std::shared_ptr<PendingCommand>& command) {
  const auto& again = *command->again;
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Call;
  header.code = again.code;
  if (again.deadline != TimePoint::max()) {
    header.deadline = std::max(again.deadline - runtime_->clock().since_boot(), Duration{1});
  }
  // For another server process this is a new call; the same server process may know the outcome of
  // the call.
  const bool known = again.sessions != 0 && command->incarnation == welcome_.incarnation;
  if (known) header.flags = sent_again;
  return calls_.send(
      header, calls_.most_open(is_builtin(again.code)),
      again.arguments.size() + (known ? sent_before_size : 0),
      [&](wire::Encoder& to) {
        if (known) SentBefore{command->session_id, command->counter}.encode(to);
        to.put_bytes(again.arguments);
      },
      command, shared_from_this());
}

tl::expected<bool, Failure> ClientConnection::send_again(
    const std::shared_ptr<PendingCommand>& command) {
  const auto& again = *command->again;
  if (auto refused = differs(again.code, again.name)) return tl::unexpected(std::move(*refused));
  const auto sent = send_repeatable(command);
  if (sent) return true;
  if (sent.error() != media::SendProblem::TooLarge) return false;
  return tl::unexpected(calls_.not_sent(again.name, again.arguments.size(), sent.error()));
}

std::vector<PendingFailover> ClientConnection::detach_repeatable() {
  auto pending = calls_.detach_repeatable(
      Ending::Silent, "the server of " + welcome_.object + " (" + connection_->peer().description +
                          ") fell silent");
  if (pending.empty()) return pending;
  leader_lock_.notify_all();
  wake_leader();
  return pending;
}

// How a command moves to another session

void PendingCommand::attach(const std::shared_ptr<ClientConnection>& session, const CommandId& id,
                            std::uint64_t as) {
  std::shared_ptr<ClientConnection> before;
  const MutexLock lock(mutex_);
  incarnation = id.incarnation;
  session_id = id.session;
  counter = id.counter;
  sent_as = as;
  retry = {};
  ++again->sessions;
  if (terminal()) return;
  before = std::exchange(session_, session);
  detail_.store(Detail::Sent, std::memory_order_relaxed);
  position_ = 0;
  fraction_ = 0;
  feedback_.clear();
  home_.store(session.get(), std::memory_order_release);
  again->attached.notify_all();
  if (before == session || !watched_) return;
  if (before) before->remove_watcher();
  session->add_watcher();
}

bool PendingCommand::wait_in_any_session(TimePoint deadline) {
  for (;;) {
    std::shared_ptr<ClientConnection> session;
    {
      MutexLock lock(mutex_);
      const auto settled = [this] { return terminal() || !awaits_failover(); };
      if (deadline == TimePoint::max()) {
        again->attached.wait(lock, settled);
      } else if (!again->attached.wait_until(lock, deadline, settled)) {
        return false;
      }
      if (terminal()) return true;
      session = session_;
    }
    const auto over = [&] { return terminal() || home_.load() != session.get(); };
    if (!session->wait(this, over, deadline)) return false;
  }
}

void PendingCommand::cancel_in_any_session() {
  for (;;) {
    std::shared_ptr<ClientConnection> session;
    std::uint64_t here = 0;
    bool at_sea = false;
    {
      const MutexLock lock(mutex_);
      if (terminal()) return;
      session = session_;
      here = counter;
      at_sea = awaits_failover();
    }
    if (at_sea) {
      return fail({Detail::Canceled,
                   "canceled while its server was gone; the command is not sent again",
                   {},
                   {}});
    }
    if (session->calls().cancel(*this, here) || home_.load() == session.get()) return;
  }
}

}  // namespace gecos::session
