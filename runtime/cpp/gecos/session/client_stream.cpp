#include "gecos/session/client_stream.hpp"

#include <algorithm>

#include "gecos/session/linked_session.hpp"
#include "gecos/session/servant.hpp"

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

}  // namespace gecos

namespace gecos::session {

ClientStream::ClientStream(std::shared_ptr<LinkedSession> session, FunctionCode code,
                           std::unique_ptr<media::StreamReader> reader)
    : session_(std::move(session)), code_(code), reader_(std::move(reader)) {}

ClientStream::~ClientStream() { session_->unsubscribe(code_); }

namespace {

/// So far from now that no age of it can be told, a stamp is nonsense, or malice.
void bound_stamp(media::StreamSample& sample) {
  constexpr std::int64_t farthest = std::int64_t{1} << 62;
  sample.stamp_ns = std::clamp(sample.stamp_ns, -farthest, farthest);
}

}  // namespace

bool ClientStream::latest(media::StreamSample& into) {
  if (session_->closed()) return false;  // the medium would still give samples
  session_->glance();
  if (session_->lost()) return false;
  reader_->latest(into.sequence, into);
  bound_stamp(into);
  return into.sequence != 0;
}

tl::expected<void, StreamEnd> ClientStream::next(media::StreamSample& into, TimePoint deadline) {
  bool got = false;
  session_->wait(
      nullptr,
      [&] {
        if (session_->closed()) return true;
        got = got || reader_->next(into.sequence, into);
        return got || session_->lost();
      },
      deadline);
  if (got) {
    bound_stamp(into);
    return {};
  }
  return tl::unexpected(lost() ? StreamEnd::Lost : StreamEnd::Nothing);
}

bool ClientStream::lost() const { return session_->lost() || session_->closed(); }

std::int64_t ClientStream::now_ns() const { return unix_now_ns(); }

}  // namespace gecos::session
