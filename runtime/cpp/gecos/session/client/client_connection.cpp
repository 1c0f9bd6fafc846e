#include "gecos/session/client/client_connection.hpp"

#include <algorithm>

#include "gecos/base/log.hpp"
#include "gecos/base/recycling_allocator.hpp"
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/client/client_stream.hpp"
#include "gecos/session/client/client_writer.hpp"
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/session/protocol/start_words.hpp"

namespace gecos::session {
namespace {

Failure left_out_because_of(const std::string& why, std::string_view operation,
                            const std::string& object) {
  return {Detail::Rejected,
          "'" + std::string(operation) + "' of " + object +
              " was not sent, because an earlier command of the same caller was not sent: " + why +
              ". Look at the outcome of a failed command before you issue the next one",
          {},
          {}};
}

}  // namespace

ClientConnection::ClientConnection(std::shared_ptr<Runtime> runtime,
                                   std::unique_ptr<media::Connection> connection, SessionId id,
                                   Welcome welcome, std::vector<FunctionCode> differing)
    : runtime_(std::move(runtime)),
      connection_(std::move(connection)),
      welcome_(std::move(welcome)),
      refused_(std::move(differing)),
      server_(runtime_->options(), runtime_->clock()),
      calls_(*runtime_, *connection_, id, welcome_, server_),
      failover_(*this),
      end_(*connection_, welcome_, calls_, receiver_, reader_, failover_),
      receiver_(id, connection_->capabilities(), calls_, leases_, end_),
      reader_(*runtime_, *connection_, calls_, receiver_, end_),
      line_(*this),
      maintenance_(*runtime_, {*connection_, welcome_, server_, calls_, receiver_, reader_,
                               failover_, end_, line_, subscriptions_}),
      subscriptions_(*this),
      writers_(id, leases_) {
  if (!log_enabled(LogLevel::Info)) return;
  log_info("client", "connected to " + welcome_.object + " (" + welcome_.interface_name +
                         ") over " + std::string(connection_->capabilities().name) + ": " +
                         connection_->peer().description);
}

ClientConnection::~ClientConnection() {
  reader_.abandon_watch();
  close(runtime_->maintenance().on_this_thread() ? Duration{} : runtime_->options().heartbeat * 2);
}

ObjectRef ClientConnection::reference() const {
  return {welcome_.object, welcome_.interface_hash, welcome_.incarnation,
          std::string(connection_->capabilities().name) + ": " + connection_->peer().description};
}

std::shared_ptr<CommandCore> ClientConnection::call(const OperationDescription& operation,
                                                    std::size_t size,
                                                    FunctionRef<void(wire::Encoder&)> encode,
                                                    const CallOptions& options) {
  if (auto refused = refusal(operation.code, operation.name)) {
    return refuse(operation, std::move(*refused));
  }
  if (options.deadline && *options.deadline <= Duration{}) {
    return refuse(
        operation,
        {Detail::Expired,
         "the deadline of '" + std::string(operation.name) +
             "' passed before the call was sent; the call was not carried out: allow it more time",
         {},
         {}});
  }
  const bool chained = operation.on_new == OnNew::Blend;
  if (chained) {
    if (const auto why = calls_.failures()->why_not_sent()) {
      return refuse(operation, left_out_because_of(*why, operation.name, object_name()));
    }
  }
  if (failover_.covers(operation)) return failover_.call(operation, size, encode, options);
  auto command = make_recycled<PendingCommand>(shared_from_this(), operation);
  command->marked_words = marked_words(operation);
  if (chained) command->chain.failures = calls_.failures();
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Call;
  header.code = operation.code;
  header.epoch = leases_.epoch();
  header.deadline = deadline_of(operation, options);

  const std::size_t most = calls_.most_open(operation.safety || is_builtin(operation.code));
  // The server may have closed the session during a rest. A call that is sent nevertheless would
  // end as OUTCOME_UNKNOWN.
  if (calls_.rests()) reader_.read_after_rest();
  auto sent = calls_.send(header, most, size, encode, command, nullptr);
  if (!sent && sent.error() == media::SendProblem::Full) {
    reader_.poll_once();  // reading the replies that wait may make room
    sent = calls_.send(header, most, size, encode, command, nullptr);
  }
  if (sent) {
    if (operation.code == GecosObjectInterface::stop.code) calls_.failures()->begins_alone();
    return command;
  }
  Failure failure = calls_.not_sent(operation.name, size, sent.error());
  if (chained && sent.error() != media::SendProblem::Lost) note_unsent(*command, failure);
  command->fail(std::move(failure));
  return command;
}

Duration ClientConnection::deadline_of(const OperationDescription& operation,
                                       const CallOptions& options) const {
  if (options.deadline) return *options.deadline;
  // The runtime issues most built-in operations by itself, for example to subscribe to a stream.
  if (is_builtin(operation.code)) return operation.quality.deadline;
  return terms(operation.quality).deadline;
}

std::shared_ptr<CommandCore> ClientConnection::refuse(const OperationDescription& operation,
                                                      Failure failure) {
  auto command = std::make_shared<PendingCommand>(std::move(failure));
  if (operation.on_new == OnNew::Blend) {
    command->chain.failures = calls_.failures();
    note_unsent(*command, command->failure());
  }
  return command;
}

/// Notes that `command`, which has @on_new("blend"), was not sent because of `failure`. Later
/// commands with @on_new("blend") are then not sent either until the program has seen this failure.
void ClientConnection::note_unsent(PendingCommand& command, const Failure& failure) {
  command.chain.place =
      calls_.failures()->not_sent(std::string(to_string(failure.detail)) + ", " + failure.text);
}

std::uint64_t ClientConnection::lease_acquired(std::uint64_t epoch) {
  calls_.failures()->acquired(epoch);
  return leases_.acquired(epoch);
}

void ClientConnection::close(Duration patience) {
  if (inbound_) inbound_->close(patience);
  end_.close(patience);
}

tl::expected<std::shared_ptr<StreamCore>, Failure> ClientConnection::subscribe(
    const StreamDescription& stream) {
  if (inbound_ && stream.status != access::Status::Sensor) {
    return tl::unexpected(Failure{
        Detail::QosUnavailable,
        "'" + std::string(stream.name) + "' of " + object_name() +
            " was not opened: readers of the stream need a status, but samples would arrive over "
            "the 'in' channel (" +
            std::string(inbound_->capabilities().name) +
            "), and only the 'out' channel can have a status; create the proxy with one medium for "
            "both directions",
        {},
        {}});
  }
  if (inbound_) return inbound_->subscribe(stream);
  if (auto refused = refusal(stream.code, stream.name, qos::Traffic::Samples)) {
    return tl::unexpected(std::move(*refused));
  }
  return subscriptions_.subscribe(stream);
}

tl::expected<std::shared_ptr<WriterCore>, Failure> ClientConnection::open_writer(
    const InwardDescription& stream) {
  if (auto refused = refusal(stream.code, stream.name, qos::Traffic::Samples)) {
    return tl::unexpected(std::move(*refused));
  }
  return ClientWriter::open(shared_from_this(), stream);
}

}  // namespace gecos::session
