#include "gecos/session/client/call_sender.hpp"

#include <algorithm>
#include <utility>

#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/retry.hpp"
#include "gecos/session/protocol/sample_time.hpp"

namespace gecos::session {
namespace {

/// Maximum time between two polls while calls are open over a medium that loses no packets. A
/// packet that the server sends without waking the client is read after at most this time.
constexpr Duration longest_sleep = std::chrono::milliseconds(50);

}  // namespace

CallSender::CallSender(Runtime& runtime, media::Connection& connection, SessionId id,
                       const Welcome& welcome, const ServerWatch& server)
    : runtime_(runtime),
      connection_(connection),
      id_(id),
      welcome_(welcome),
      server_(server),
      repeats_(!connection.capabilities().reliable),
      withdrawal_(connection) {}

tl::expected<void, media::SendProblem> CallSender::send(
    wire::PacketHeader& header, std::size_t most, std::size_t size,
    FunctionRef<void(wire::Encoder&)> encode, const std::shared_ptr<PendingCommand>& command,
    const std::shared_ptr<ClientConnection>& attach_to) {
  const MutexLock lock(mutex_);
  if (lost_.load(std::memory_order_relaxed)) return tl::unexpected(media::SendProblem::Lost);
  if (calls_.size() >= most) return tl::unexpected(media::SendProblem::Full);
  const auto chain = command->keeps_place() ? failures_->next() : SeenFailures::Says{};
  const std::size_t with_report = size + (chain.flags == reports ? chain.report.encoded_size() : 0);
  if (wire::packet_size(with_report) > connection_.capabilities().largest_packet) {
    return tl::unexpected(media::SendProblem::TooLarge);
  }
  header.session = id_;
  header.counter = calls_.next_counter();
  if (command->keeps_place()) header.flags = chain.flags;
  if (repeats_) header.acknowledged = calls_.finished_up_to();
  if (chain.flags == reports) {
    write_packet(packet_, header, with_report, [&](wire::Encoder& to) {
      chain.report.encode(to);
      encode(to);
    });
  } else {
    write_packet(packet_, header, size, encode);
  }
  const auto sent = send_first(packet_);
  if (!sent && !(repeats_ && sent.error() == media::SendProblem::Full)) {
    return tl::unexpected(sent.error());
  }
  calls_.issue();
  failures_->sent(chain);
  command->chain.place = {true, header.counter};
  if (attach_to) {
    command->attach(attach_to, {welcome_.incarnation, number(id_), header.counter},
                    sent.value_or(0));
  } else {
    command->counter = header.counter;
    command->session_id = number(id_);
    command->incarnation = welcome_.incarnation;
    command->sent_as = sent.value_or(0);
  }
  if (repeats_) {
    auto& retry = command->retry;
    const TimePoint now = runtime_.clock().now();
    retry.packet = packet_;
    retry.first = now;
    retry.next = now + retry_after(1);
    retry.on_its_way = sent.has_value();
    const TimePoint since_boot = runtime_.clock().since_boot();
    if (header.deadline > Duration{} && header.deadline < TimePoint::max() - since_boot) {
      retry.deadline = since_boot + header.deadline;
    }
  }
  calls_.add(header.counter, command);
  if (repeats_ && idle_rest_.call_sent()) runtime_.maintenance().wake_requesters();
  return {};
}

/// Sends a packet with a call. Over a medium that loses packets, sends nothing while the server is
/// unreachable, because the server would read the call only after the client has given it up.
tl::expected<std::uint64_t, media::SendProblem> CallSender::send_first(ByteView packet) {
  if (repeats_ && server_.unreachable()) return tl::unexpected(media::SendProblem::Full);
  return connection_.send(packet, {});
}

Failure CallSender::not_sent(std::string_view name, std::size_t size, media::SendProblem problem) {
  const std::string what = "'" + std::string(name) + "' of " + welcome_.object;
  switch (problem) {
    case media::SendProblem::Full: {
      const MutexLock lock(mutex_);
      if (calls_.size() < welcome_.credits) {
        return {Detail::QueueFull,
                what + " was not sent: " + std::string(connection_.capabilities().name) +
                    " is full of packets that the server has not read yet; wait "
                    "for an earlier call to end",
                {},
                {}};
      }
      return {Detail::QueueFull,
              what + " was not sent: " + std::to_string(welcome_.credits) +
                  " calls are unanswered; wait until one of them has ended",
              {},
              {}};
    }
    case media::SendProblem::TooLarge:
      return {Detail::BadParameter,
              what + " was not sent: its arguments take " + std::to_string(size) + " bytes, but " +
                  std::string(connection_.capabilities().name) + " carries at most " +
                  std::to_string(connection_.capabilities().largest_packet) + "; send less at once",
              {},
              {}};
    case media::SendProblem::Lost:
      break;
  }
  const MutexLock lock(mutex_);
  return {Detail::NoServer,
          what + " was not sent: " + (loss_.text.empty() ? "the connection is lost" : loss_.text) +
              "; create a new proxy",
          {},
          {}};
}

bool CallSender::cancel(PendingCommand& command, std::uint64_t counter) {
  const MutexLock lock(mutex_);
  const auto* const found = calls_.find(counter);
  if (command.terminal() || found == nullptr || found->get() != &command) return false;
  if (!std::exchange(command.retry.cancel, true)) command.retry.cancel_up_to = calls_.issued();
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Cancel;
  header.counter = counter;
  if (!send_packet(header, cancel_body(command.retry.cancel_up_to))) {
    command.retry.next = {};  // the maintenance thread tries again
    cancels_waiting_ = true;
    runtime_.maintenance().wake();
  }
  return true;
}

/// Sends a packet that is not a call.
tl::expected<std::uint64_t, media::SendProblem> CallSender::send_packet(wire::PacketHeader header,
                                                                        ByteView body) {
  header.session = id_;
  header.acknowledged = repeats_ ? calls_.finished_up_to() : 0;
  write_packet(packet_, header, body);
  return connection_.send(packet_, {});
}

std::uint64_t CallSender::issued() {
  const MutexLock lock(mutex_);
  return calls_.issued();
}

std::size_t CallSender::open() {
  const MutexLock lock(mutex_);
  return calls_.size();
}

void CallSender::with_connection(FunctionRef<void(media::Connection&)> use) {
  const MutexLock lock(mutex_);
  use(connection_);
}

bool CallSender::everything_arrived() {
  const MutexLock lock(mutex_);
  return calls_.everything_arrived();
}

bool CallSender::has_repeatable() {
  const MutexLock lock(mutex_);
  return calls_.has_repeatable();
}

TimePoint CallSender::by_our_clock(TimePoint theirs) {
  const auto difference = connection_.clock_difference();
  if (!difference) return theirs;
  const MutexLock lock(mutex_);
  return theirs + std::clamp(*difference, -longest_age, longest_age) - quickest_answer_;
}

std::shared_ptr<PendingCommand> CallSender::take_replied(std::uint64_t counter) {
  const MutexLock lock(mutex_);
  auto command = calls_.take(counter);
  if (command && command->timed) command->answered = runtime_.clock().now();
  if (command && repeats_) {
    quickest_answer_ = std::min(quickest_answer_, runtime_.clock().now() - command->retry.first);
  }
  return command;
}

std::shared_ptr<PendingCommand> CallSender::arrived(std::uint64_t counter) {
  const MutexLock lock(mutex_);
  const auto* const found = calls_.find(counter);
  if (found == nullptr) return nullptr;
  (*found)->retry.arrived = true;
  return *found;
}

// The functions below send packets on the maintenance thread.

void CallSender::query_old_calls() {
  if (repeats_) return;
  const MutexLock lock(mutex_);
  for (const auto& [counter, command] : calls_.all()) {
    if (counter > open_when_asked_) break;
    wire::PacketHeader header;
    header.kind = wire::PacketKind::Query;
    header.counter = counter;
    if (!send_packet(header)) break;
  }
  open_when_asked_ = calls_.issued();
}

/// Over a medium that loses packets, sends each open call again with the same counter. Until the
/// server has confirmed the arrival of the call, sends the whole call; after that, only a Query for
/// its outcome.
TimePoint CallSender::repeat(TimePoint now, TimePoint next_beat) {
  const MutexLock lock(mutex_);
  // Over a medium that loses packets, the thread may have to repeat the next call, so that it rests
  // only while the client is idle.
  const bool rests = !repeats_ || idle_rest_.tick(calls_.issued(), calls_.size());
  if (calls_.size() == 0) return rests ? next_beat : std::min(next_beat, now + retry_after(1));
  if (!repeats_ && !cancels_waiting_) return std::min(next_beat, now + longest_sleep);
  const TimePoint soon = now + Maintenance::tick;
  cancels_waiting_ = false;
  for (const auto& [counter, command] : calls_.all()) {
    auto& retry = command->retry;
    if (!repeats_ && !retry.cancel) continue;
    if (now < retry.next) continue;
    wire::PacketHeader header;
    header.counter = counter;
    if (retry.cancel) {
      header.kind = wire::PacketKind::Cancel;
      if (!send_packet(header, cancel_body(retry.cancel_up_to))) cancels_waiting_ = true;
    }
    if (repeats_ && retry.arrived) {
      header.kind = wire::PacketKind::Query;
      static_cast<void>(send_packet(header));
    } else if (repeats_ && !server_.unreachable()) {
      if (retry.deadline != TimePoint::max()) {
        const Duration left = retry.deadline - runtime_.clock().since_boot();
        wire::write_deadline(retry.packet, std::max(left, Duration{1}));
      }
      if (connection_.send(retry.packet, {})) retry.on_its_way = true;
    }
    retry.next = now + retry_after(++retry.sent);
    if (!repeats_) retry.cancel = cancels_waiting_;
  }
  return soon;
}

// The functions below are about the end of a session.

bool CallSender::say_goodbye() {
  const MutexLock lock(mutex_);
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Goodbye;
  return send_packet(header).has_value();
}

SessionLoss CallSender::loss() {
  const MutexLock lock(mutex_);
  return loss_;
}

std::optional<CallSender::Remains> CallSender::end(Ending how, const std::string& text,
                                                   Queued queued) {
  const MutexLock lock(mutex_);
  if (lost_.load(std::memory_order_relaxed)) return std::nullopt;
  loss_ = {how, text};
  lost_.store(true, std::memory_order_release);
  if (queued == Queued::Withdrawn && !withdrawal_.write(calls_.issued())) withdraw_by_packet();
  Remains remains;
  // Only a loss that the medium or the server has reported leaves calls to failover, which then has
  // the time `grace` from now on to find another server. When the server fell silent, `grace` has
  // already passed.
  if (how == Ending::Died || closed_by_server(how)) remains.repeatable = detach(how, text);
  remains.others = calls_.take_all();
  return remains;
}

/// Withdraws the calls by a packet. Over a medium that loses packets, sends several copies, because
/// no thread sends the packet again later. A suspended server reads the packet when it runs again.
void CallSender::withdraw_by_packet() {
  constexpr int copies = 3;
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Goodbye;
  header.flags = withdraws;
  for (int left = repeats_ ? copies : 1; left > 0; --left) static_cast<void>(send_packet(header));
}

Failure CallSender::failure_of(const PendingCommand& command, Ending how, const std::string& text) {
  const MutexLock lock(mutex_);
  return withdrawal_.failure_of(command, how, text);
}

std::vector<PendingFailover> CallSender::detach_repeatable(Ending how, const std::string& text) {
  const MutexLock lock(mutex_);
  return detach(how, text);
}

std::vector<PendingFailover> CallSender::detach(Ending how, const std::string& text) {
  const auto repeatable = calls_.take_repeatable();
  std::vector<PendingFailover> pending;
  if (repeatable.empty()) return pending;
  const TimePoint since = server_.unreachable() ? server_.silent_since() : runtime_.clock().now();
  for (const auto& [counter, command] : repeatable) {
    Failure failure = withdrawal_.failure_of(*command, how, text);
    if (failure.state() != State::ConnectionFailed) command->again->may_have_started = true;
    command->detach();
    pending.push_back({command, std::move(failure), since + runtime_.options().grace});
  }
  return pending;
}

}  // namespace gecos::session
