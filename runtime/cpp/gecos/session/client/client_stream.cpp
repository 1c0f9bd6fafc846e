#include "gecos/session/client/client_stream.hpp"

#include <algorithm>
#include <ostream>

#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/sample_time.hpp"

namespace gecos {

std::string_view to_string(StreamEnd end) {
  switch (end) {
    case StreamEnd::Nothing:
      return "NOTHING";
    case StreamEnd::Lost:
      return "LOST";
  }
  return "?";
}

std::ostream& operator<<(std::ostream& out, StreamEnd end) {
  out << to_string(end);
  switch (end) {
    case StreamEnd::Nothing:
      return out << ": no sample arrived in time; call next() again";
    case StreamEnd::Lost:
      return out << ": the stream's server is gone or its Lab is closed; create a new proxy and "
                    "subscribe again";
  }
  return out;
}

}  // namespace gecos

namespace gecos::session {

ClientStream::ClientStream(std::shared_ptr<ClientConnection> session, FunctionCode code,
                           std::unique_ptr<media::StreamReader> reader,
                           std::optional<std::uint64_t> after)
    : session_(std::move(session)), code_(code), reader_(std::move(reader)), after_(after) {}

ClientStream::~ClientStream() { session_->subscriptions().unsubscribe(code_); }

/// Only a malicious or broken server sends a sample without its measurement time. The bytes of such
/// a sample are removed, so that the sample does not decode.
void ClientStream::finish(RawSample& sample) const {
  constexpr std::int64_t farthest = std::int64_t{1} << 62;
  sample.stamp_ns = std::clamp(sample.stamp_ns, -farthest, farthest);
  const auto measured = take_measured(sample.bytes);
  if (!measured) sample.bytes.clear();
  sample.measured = session_->calls().by_our_clock(measured.value_or(TimePoint(-longest_age)));
}

bool ClientStream::latest(RawSample& into) {
  if (lost()) return false;  // after a loss the medium would still return old samples
  if (reader_->latest(into.sequence, into)) finish(into);
  return into.sequence != after_.value_or(0);
}

tl::expected<void, StreamEnd> ClientStream::next(RawSample& into, TimePoint deadline) {
  bool got = false;
  session_->reader().wait(
      nullptr,
      [&] {
        if (session_->closed()) return true;
        got = got || reader_->next(into.sequence, into);
        return got || session_->lost();
      },
      deadline);
  if (got) {
    finish(into);
    return {};
  }
  return tl::unexpected(lost() ? StreamEnd::Lost : StreamEnd::Nothing);
}

bool ClientStream::lost() const { return session_->lost() || session_->closed(); }

Duration ClientStream::age(const RawSample& sample) const {
  return std::max(session_->runtime().clock().since_boot() - sample.measured, Duration::zero());
}

}  // namespace gecos::session
