#include "gecos/session/client/client_connection.hpp"

#include <algorithm>

#include "gecos/base/log.hpp"
#include "gecos/base/recycling_allocator.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/retry.hpp"
#include "gecos/session/protocol/sample_time.hpp"
#include "gecos/session/protocol/start_words.hpp"

namespace gecos::session {
namespace {

/// A silent server becomes UNREACHABLE a little before it would itself end this client's status for
/// silence. So commands end at most `grace` + `lease_ttl` after the server died, including the time
/// until its death is detected.
PeerLiveness::Bounds bounds_of_server(const LabOptions& options) {
  const Duration suspect =
      std::max(options.lease_ttl - 2 * options.heartbeat, 2 * options.heartbeat);
  return {.suspect_after = suspect, .dead_after = suspect + options.grace};
}

}  // namespace

ClientConnection::ClientConnection(std::shared_ptr<Runtime> runtime,
                                   std::unique_ptr<media::Connection> connection, SessionId id,
                                   Welcome welcome, std::vector<FunctionCode> differing)
    : runtime_(std::move(runtime)),
      connection_(std::move(connection)),
      id_(id),
      welcome_(std::move(welcome)),
      differing_(std::move(differing)),
      repeats_(!connection_->capabilities().reliable),
      spin_(system_clock()),
      // This clock may advance by `lease_ttl` in one step, because all packets that have arrived
      // are read before the server is judged. Smaller steps would delay the verdict on a busy
      // machine.
      liveness_clock_(runtime_->clock().now(), runtime_->options().lease_ttl),
      liveness_(bounds_of_server(runtime_->options())),
      answers_(runtime_->options().lease_ttl,
               2 * (runtime_->options().lease_ttl + runtime_->options().grace),
               liveness_clock_.now()) {
  liveness_.heard(liveness_clock_.now());
  // A reader of a stream allocates nothing, not even in its first sleep.
  descriptors_.reserve(connection_->descriptors().size() + 1);
  if (!log_enabled(LogLevel::Info)) return;
  log_info("client", "connected to " + welcome_.object + " (" + welcome_.interface_name +
                         ") over " + std::string(connection_->capabilities().name) + ": " +
                         connection_->peer().description);
}

ObjectRef ClientConnection::reference() const {
  return {welcome_.object, welcome_.interface_hash, welcome_.incarnation,
          std::string(connection_->capabilities().name) + ": " + connection_->peer().description};
}

ClientConnection::~ClientConnection() {
  // the maintenance thread took the lead and cannot drop it any more
  if (watching_) leader_lock_.drop();
  close(runtime_->maintenance().on_this_thread() ? Duration{} : runtime_->options().heartbeat * 2);
}

// Sending calls

std::shared_ptr<CommandCore> ClientConnection::call(const OperationDescription& operation,
                                                    std::size_t size,
                                                    FunctionRef<void(wire::Encoder&)> encode,
                                                    const CallOptions& options) {
  if (auto refused = differs(operation.code, operation.name)) return ended(std::move(*refused));
  if (options.deadline && *options.deadline <= Duration{}) {
    return ended({Detail::Expired,
                  "the deadline of '" + std::string(operation.name) +
                      "' passed before it was sent; it was not carried out",
                  {},
                  {}});
  }
  if (failover_ && operation.idempotent && operation.status == access::Status::Sensor) {
    return call_repeatable(operation, size, encode, options);
  }
  auto command = make_recycled<PendingCommand>(shared_from_this(), operation);
  command->marked_words = marked_words(operation);
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Call;
  header.code = operation.code;
  header.session = id_;
  header.epoch = Epoch{epoch_.load(std::memory_order_relaxed)};
  header.deadline = options.deadline.value_or(operation.quality.deadline);

  const std::size_t most = most_open(operation.safety || is_builtin(operation.code));
  auto sent = send_call(header, most, size, encode, command);
  if (!sent && sent.error() == media::SendProblem::Full) {
    poll_once();  // reading waiting replies may make room
    sent = send_call(header, most, size, encode, command);
  }
  if (!sent) command->fail(not_sent(operation.name, size, sent.error()));
  return command;
}

tl::expected<void, media::SendProblem> ClientConnection::send_call(
    wire::PacketHeader& header, std::size_t most, std::size_t size,
    FunctionRef<void(wire::Encoder&)> encode, const std::shared_ptr<PendingCommand>& command) {
  const MutexLock lock(mutex_);
  if (lost_.load(std::memory_order_relaxed)) return tl::unexpected(media::SendProblem::Lost);
  if (calls_.size() >= most) return tl::unexpected(media::SendProblem::Full);
  if (wire::packet_size(size) > connection_->capabilities().largest_packet) {
    return tl::unexpected(media::SendProblem::TooLarge);
  }
  header.counter = next_counter_;
  if (repeats_) header.acknowledged = finished_up_to();
  write_packet(packet_, header, size, encode);
  const auto sent = send_first(packet_);
  if (!sent && !(repeats_ && sent.error() == media::SendProblem::Full)) {
    return tl::unexpected(sent.error());
  }
  ++next_counter_;
  if (command->again) {
    command->attach(shared_from_this(), {welcome_.incarnation, number(id_), header.counter},
                    sent.value_or(0));
  } else {
    command->counter = header.counter;
    command->session_id = number(id_);
    command->incarnation = welcome_.incarnation;
    command->sent_as = sent.value_or(0);
  }
  if (repeats_) {
    auto& retry = command->retry;
    const TimePoint now = runtime_->clock().now();
    retry.packet = packet_;
    retry.first = now;
    retry.next = now + retry_after(1);
    retry.on_its_way = sent.has_value();
    const TimePoint since_boot = runtime_->clock().since_boot();
    if (header.deadline > Duration{} && header.deadline < TimePoint::max() - since_boot) {
      retry.deadline = since_boot + header.deadline;
    }
  }
  calls_.insert(header.counter, command);
  return {};
}

/// Sends a packet with a call. Over a medium that loses packets, sends nothing while the server is
/// unreachable: the server would read the call only after the client has given it up.
tl::expected<std::uint64_t, media::SendProblem> ClientConnection::send_first(ByteView packet) {
  if (repeats_ && unreachable()) return tl::unexpected(media::SendProblem::Full);
  return connection_->send(packet, {});
}

/// Returns a failure when client and server define the operation differently. Such a call is not
/// sent: the server would decode wrong arguments.
std::optional<Failure> ClientConnection::differs(FunctionCode code, std::string_view name) const {
  if (!std::binary_search(differing_.begin(), differing_.end(), code)) return std::nullopt;
  return Failure{Detail::Refused,
                 "'" + std::string(name) + "' of " + welcome_.object +
                     " was not sent: the server's " + welcome_.interface_name +
                     " defines it differently than this program; rebuild the older of the two from "
                     "the newer interface (`gidl breaking` shows what differs)",
                 {},
                 {}};
}

Failure ClientConnection::not_sent(std::string_view name, std::size_t size,
                                   media::SendProblem problem) {
  const std::string what = "'" + std::string(name) + "' of " + welcome_.object;
  switch (problem) {
    case media::SendProblem::Full: {
      const MutexLock lock(mutex_);
      if (calls_.size() < welcome_.credits) {
        return {Detail::QueueFull,
                what + " was not sent: " + std::string(connection_->capabilities().name) +
                    " is full of packets that the server has not read yet; wait "
                    "for an earlier call to end",
                {},
                {}};
      }
      return {Detail::QueueFull,
              what + " was not sent: " + std::to_string(welcome_.credits) +
                  " calls are unanswered; wait for one of them",
              {},
              {}};
    }
    case media::SendProblem::TooLarge:
      return {Detail::BadParameter,
              what + " was not sent: its arguments take " + std::to_string(size) + " bytes and " +
                  std::string(connection_->capabilities().name) + " carries " +
                  std::to_string(connection_->capabilities().largest_packet),
              {},
              {}};
    case media::SendProblem::Lost:
      break;
  }
  const MutexLock lock(mutex_);
  return {Detail::NoServer,
          what + " was not sent: " + (loss_text_.empty() ? "the connection is lost" : loss_text_) +
              "; create a new proxy",
          {},
          {}};
}

bool ClientConnection::cancel(PendingCommand& command, std::uint64_t counter) {
  const MutexLock lock(mutex_);
  const auto* const found = calls_.find(counter);
  if (command.terminal() || found == nullptr || found->get() != &command) return false;
  command.retry.cancel = true;
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Cancel;
  header.counter = counter;
  if (!send(header, {})) {
    command.retry.next = {};  // the maintenance thread tries again
    cancels_waiting_ = true;
    wake_maintenance();
  }
  return true;
}

tl::expected<std::uint64_t, media::SendProblem> ClientConnection::send(wire::PacketHeader header,
                                                                       ByteView body) {
  header.session = id_;
  header.acknowledged = repeats_ ? finished_up_to() : 0;
  write_packet(packet_, header, body);
  return connection_->send(packet_, {});
}

TimePoint ClientConnection::by_our_clock(TimePoint theirs) {
  const auto difference = connection_->clock_difference();
  if (!difference) return theirs;
  const MutexLock lock(mutex_);
  return theirs + std::clamp(*difference, -longest_age, longest_age) - quickest_answer_;
}

std::uint64_t ClientConnection::lease_acquired(std::uint64_t epoch) {
  const MutexLock lock(mutex_);
  if (epoch_.exchange(epoch, std::memory_order_relaxed) != epoch) {
    ++statuses_;
    leases_ = 0;
  }
  ++leases_;
  return statuses_;
}

void ClientConnection::lease_released(std::uint64_t held) {
  const MutexLock lock(mutex_);
  if (held != statuses_ || --leases_ != 0) return;
  epoch_.store(0, std::memory_order_relaxed);
}

std::uint64_t ClientConnection::issued() {
  const MutexLock lock(mutex_);
  return next_counter_ - 1;
}

std::uint64_t ClientConnection::finished_up_to() const {
  const auto open = calls_.lowest();
  return open != 0 ? open - 1 : next_counter_ - 1;
}

// How a session ends

void ClientConnection::lose(Ending how, const std::string& text) {
  std::vector<std::pair<std::uint64_t, std::shared_ptr<PendingCommand>>> open;
  std::vector<PendingFailover> pending;
  bool goes_on = false;
  {
    const MutexLock lock(mutex_);
    if (lost_.load(std::memory_order_relaxed)) return;
    loss_text_ = text;
    lost_.store(true, std::memory_order_release);
    // After a goodbye that the server acknowledged, the calls queued at the server still run. They
    // also still run when this program does not wait for the acknowledgement: then a proxy was
    // dropped, and its commands are meant to continue.
    const bool drains =
        how == Ending::ByUs && (goodbye_heard_.load(std::memory_order_relaxed) || !awaits_goodbye_);
    goes_on = drains;
    if (connection_->capabilities().shared_words && !drains) {
      connection_->write_word(withdrawn_word, next_counter_ - 1);
      withdrawn_ = true;  // set before any call is reported: no call can start any more
    } else if (!drains) {
      withdraw_by_packet();
    }
    // When the loss was reported, failover has `grace` to find another server. When the server fell
    // silent, `grace` has already passed.
    if (how == Ending::Died || how == Ending::Closed) pending = detach(how, text);
    open = calls_.take_all();
  }
  log_info("client", "the session with " + welcome_.object + " ended: " + text);
  for (const auto& [counter, command] : open) {
    // no failure is logged: the program closed the session on purpose
    if (goes_on) command->observe();
    Failure failure;
    {
      const MutexLock lock(mutex_);
      failure = failure_of(*command, how, text);
    }
    command->fail(std::move(failure));
  }
  leader_lock_.notify_all();
  wake_leader();
  if (!pending.empty()) failover_->take(shared_from_this(), std::move(pending));
}

/// Withdraws the calls by a packet. Sends several copies over a medium that loses packets, because
/// no thread repeats the packet later. A suspended server reads the packet when it continues.
void ClientConnection::withdraw_by_packet() {
  constexpr int copies = 3;
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Goodbye;
  header.flags = withdraws;
  for (int left = repeats_ ? copies : 1; left > 0; --left) static_cast<void>(send(header, {}));
}

Failure ClientConnection::failure_of(const PendingCommand& command, Ending how,
                                     const std::string& text) const {
  if (repeats_ && !command.retry.on_its_way) {
    return {Detail::NotStarted, text + "; this command was never sent", {}, {}};
  }
  if (!may_have_started(command, how)) {
    return {Detail::NotStarted, text + " before it started this command", {}, {}};
  }
  if (how == Ending::Died) {
    return {
        Detail::ServerCrashed, text + "; the command may have been carried out in part", {}, {}};
  }
  return {
      Detail::OutcomeUnknown, text + "; whether the command was carried out is not known", {}, {}};
}

/// Returns false only when it is proved that the server has not started the call and never will.
/// When the medium has shared words, must be called after the withdrawal is written.
bool ClientConnection::may_have_started(const PendingCommand& command, Ending how) const {
  if (how == Ending::Broken) return true;  // the shared words of a broken server prove nothing
  if (withdrawn_ && command.marked_words != 0) {
    for (std::size_t word = 0; word < media::shared_word_count; ++word) {
      const bool may_stand_here = (command.marked_words >> word & 1U) != 0;
      if (may_stand_here && connection_->peer_word(word) >= command.counter) return true;
    }
    return false;
  }
  // A server that is gone reads no more packets. A server that is only silent may still read them.
  if (how != Ending::Died && how != Ending::Closed) return true;
  const auto taken = connection_->taken_by_peer();
  return !taken || command.sent_as <= *taken;
}

void ClientConnection::close(Duration patience) {
  closed_.store(true, std::memory_order_relaxed);
  if (lost()) return;
  const TimePoint give_up = deadline_after(patience);
  if (repeats_ && patience > Duration{}) {
    wait(
        nullptr, [this] { return lost() || everything_arrived(); }, give_up);
  }
  {
    const MutexLock lock(mutex_);
    awaits_goodbye_ = patience > Duration{};
  }
  bool sent = false;
  int tries = 1;
  do {
    if (!sent || repeats_) {
      const MutexLock lock(mutex_);
      wire::PacketHeader header;
      header.kind = wire::PacketKind::Goodbye;
      sent = send(header, {}).has_value();
    }
    if (patience == Duration{}) break;
    const TimePoint next = sent && !repeats_ ? give_up : deadline_after(retry_after(tries++));
    wait(
        nullptr, [this] { return goodbye_heard_.load() || lost(); }, std::min(next, give_up));
  } while (!lost() && std::chrono::steady_clock::now() < give_up);
  lose(Ending::ByUs, closed_by_us);
}

bool ClientConnection::everything_arrived() {
  const MutexLock lock(mutex_);
  for (const auto& [counter, command] : calls_.all()) {
    if (!command->retry.arrived) return false;
  }
  return true;
}

}  // namespace gecos::session
