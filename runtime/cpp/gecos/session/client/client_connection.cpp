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
ClientConnection::ClientConnection(std::shared_ptr<Runtime> runtime,
                                   std::unique_ptr<media::Connection> connection, SessionId id,
                                   Welcome welcome, std::vector<FunctionCode> differing)
    : runtime_(std::move(runtime)),
      connection_(std::move(connection)),
      id_(id),
      welcome_(std::move(welcome)),
      differing_(std::move(differing)),
      repeats_(!connection_->capabilities().reliable),
      server_(runtime_->options(), runtime_->clock()),
      calls_(*runtime_, *connection_, id_, welcome_, server_),
      spin_(system_clock()) {
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
  header.epoch = leases_.epoch();
  header.deadline = options.deadline.value_or(operation.quality.deadline);

  const std::size_t most = calls_.most_open(operation.safety || is_builtin(operation.code));
  auto sent = calls_.send(header, most, size, encode, command, nullptr);
  if (!sent && sent.error() == media::SendProblem::Full) {
    poll_once();  // reading waiting replies may make room
    sent = calls_.send(header, most, size, encode, command, nullptr);
  }
  if (!sent) command->fail(calls_.not_sent(operation.name, size, sent.error()));
  return command;
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

// How a session ends

void ClientConnection::lose(Ending how, const std::string& text) {
  // After a goodbye that the server acknowledged, the calls queued at the server still run. They
  // also still run when this program does not wait for the acknowledgement: then a proxy was
  // dropped, and its commands are meant to continue.
  const bool drains = how == Ending::ByUs && (goodbye_heard_.load(std::memory_order_relaxed) ||
                                              !awaits_goodbye_.load(std::memory_order_relaxed));
  auto remains =
      calls_.end(how, text, drains ? CallSender::Queued::Run : CallSender::Queued::Withdrawn);
  if (!remains) return;
  log_info("client", "the session with " + welcome_.object + " ended: " + text);
  for (const auto& [counter, command] : remains->others) {
    // no failure is logged: the program closed the session on purpose
    if (drains) command->observe();
    command->fail(calls_.failure_of(*command, how, text));
  }
  leader_lock_.notify_all();
  wake_leader();
  if (!remains->repeatable.empty()) {
    failover_->take(shared_from_this(), std::move(remains->repeatable));
  }
}

void ClientConnection::close(Duration patience) {
  closed_.store(true, std::memory_order_relaxed);
  if (lost()) return;
  const TimePoint give_up = deadline_after(patience);
  if (repeats_ && patience > Duration{}) {
    wait(
        nullptr, [this] { return lost() || calls_.everything_arrived(); }, give_up);
  }
  awaits_goodbye_.store(patience > Duration{}, std::memory_order_relaxed);
  bool sent = false;
  int tries = 1;
  do {
    if (!sent || repeats_) sent = calls_.say_goodbye();
    if (patience == Duration{}) break;
    const TimePoint next = sent && !repeats_ ? give_up : deadline_after(retry_after(tries++));
    wait(
        nullptr, [this] { return goodbye_heard_.load() || lost(); }, std::min(next, give_up));
  } while (!lost() && std::chrono::steady_clock::now() < give_up);
  lose(Ending::ByUs, closed_by_us);
}

}  // namespace gecos::session
