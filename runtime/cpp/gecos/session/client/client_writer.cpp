#include "gecos/session/client/client_writer.hpp"

#include <exception>
#include <utility>

#include "gecos/object_calls.hpp"      // generated from idl/gecos/object.gidl
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/own_call.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/inward_sample.hpp"
#include "gecos/session/protocol/sample_bounds.hpp"
#include "gecos/session/protocol/sample_time.hpp"

namespace gecos::session {
namespace {

constexpr Duration between_questions = std::chrono::milliseconds(5);

}  // namespace

tl::expected<std::shared_ptr<WriterCore>, Failure> ClientWriter::open(
    std::shared_ptr<ClientConnection> session, const InwardDescription& stream) {
  const std::string what =
      "inward stream '" + std::string(stream.name) + "' of " + session->object_name();
  const std::size_t largest = stream.largest != 0 ? stream.largest : unbounded_sample;
  const std::size_t depth = stream.quality.depth != 0 ? stream.quality.depth : usual_depth;
  const std::uint32_t id = session->writers().new_id();
  std::shared_ptr<ClientWriter> opened;
  std::string failed = "the connection is lost or has no room for another stream";
  session->calls().with_connection([&](media::Connection& connection) {
    try {
      auto writer = connection.make_stream(inward_header_size + largest + measured_bytes, depth);
      if (!connection.share(id, *writer)) return;
      opened = std::make_shared<ClientWriter>(session, stream, std::move(writer), id);
    } catch (const std::exception& error) {  // also if no memory or no descriptor is left
      failed = error.what();
    }
  });
  if (!opened) {
    return tl::unexpected(Failure{Detail::Refused,
                                  what + " cannot be opened over " +
                                      std::string(session->capabilities().name) + ": " + failed,
                                  {},
                                  {}});
  }
  if (auto failure = opened->await_reader()) return tl::unexpected(std::move(*failure));
  return opened;
}

ClientWriter::ClientWriter(std::shared_ptr<ClientConnection> session,
                           const InwardDescription& stream,
                           std::unique_ptr<media::StreamWriter> writer, std::uint32_t id)
    : session_(std::move(session)), stream_(stream), writer_(std::move(writer)), id_(id) {}

ClientWriter::~ClientWriter() {
  if (session_->lost() || session_->closed()) return;
  session_->calls().with_connection(
      [&](media::Connection& connection) { connection.unshare(id_); });
  if (!opened_) return;
  own_call(*session_, GecosObjectInterface::end_feed,
           GecosObject_end_feed_arguments{number(stream_.code), id_})
      ->observe();
}

/// Asks the server to read the stream, and repeats the request until the server confirms it. Over
/// some media, the announcement of the stream arrives after the first request; the server then
/// confirms only a later request.
std::optional<Failure> ClientWriter::await_reader() {
  const TimePoint deadline = deadline_after(session_->runtime().options().grace);
  for (;;) {
    const auto asked = own_call(*session_, GecosObjectInterface::feed,
                                GecosObject_feed_arguments{number(stream_.code), id_});
    asked->wait_until(TimePoint::max());
    if (asked->progress().detail != Detail::Done) return asked->failure();
    wire::Decoder from(asked->result());
    if (!read_result<GecosObject_feed_result>(from, opened_)) {
      return Failure{Detail::Fault, "the reply does not decode: " + from.error().message(), {}, {}};
    }
    if (opened_) return std::nullopt;
    if (std::chrono::steady_clock::now() >= deadline) {
      return Failure{Detail::OutcomeUnknown,
                     what() + " could not be opened in time over " +
                         std::string(session_->capabilities().name),
                     {},
                     {}};
    }
    session_->reader().wait(
        nullptr, [&] { return session_->lost(); }, deadline_after(between_questions));
  }
}

std::string ClientWriter::what() const {
  return "inward stream '" + std::string(stream_.name) + "' of " + session_->object_name();
}

tl::unexpected<Failure> ClientWriter::not_sent(Detail detail, const std::string& why) const {
  return tl::unexpected(
      Failure{detail, "a sample for " + what() + " was not sent: " + why, {}, {}});
}

tl::expected<void, Failure> ClientWriter::send(std::size_t size,
                                               FunctionRef<void(wire::Encoder&)> encode,
                                               std::int64_t stamp_ns) {
  if (lost()) {
    return tl::unexpected(session_->calls().not_sent(stream_.name, size, media::SendProblem::Lost));
  }
  Writers& writers = session_->writers();
  const InwardHeader header{writers.session(), writers.epoch(), fed_ ? fed_->counter : 0};
  if (header.epoch == Epoch{} && stream_.status != access::Status::Sensor) {
    const auto status = std::string(access::to_string(stream_.status));
    return not_sent(Detail::Denied, "the stream needs " + status +
                                        " status; hold a lease while you send: call " + status +
                                        "(object) of gecos");
  }
  if (fed_ && fed_->session != number(header.session)) {
    if (fed_->counter != 0) {
      return not_sent(Detail::BadParameter,
                      "the command that the sample feeds belongs to another session");
    }
    return not_sent(Detail::BadParameter, "the command that the sample feeds was not sent");
  }
  const auto lent = writer_->lend(inward_header_size + size + measured_bytes);
  if (!lent) {
    return not_sent(Detail::BadParameter,
                    "the sample takes " + std::to_string(size) + " bytes, more than " +
                        std::string(session_->capabilities().name) + " can send for this stream");
  }
  const SampleTime time = sample_time(stamp_ns, session_->runtime().clock());
  write_inward_header(lent->first<inward_header_size>(), header);
  wire::Encoder value(lent->subspan(inward_header_size, size));
  encode(value);
  write_measured(lent->last<measured_bytes>(), time.measured);
  writer_->publish_lent(time.stamp_ns);
  writers.note_sample();
  return {};
}

void ClientWriter::feeds(std::optional<CommandId> id) { fed_ = id; }

Command<FeedReport> ClientWriter::report() {
  return {own_call(*session_, GecosObjectInterface::feed_report,
                   GecosObject_feed_report_arguments{number(stream_.code)}),
          read_result<GecosObject_feed_report_result, FeedReport>};
}

bool ClientWriter::lost() const { return session_->lost() || session_->closed(); }

}  // namespace gecos::session
