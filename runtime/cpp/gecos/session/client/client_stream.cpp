#include "gecos/session/client/client_stream.hpp"

#include <algorithm>
#include <ostream>
#include <utility>

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
    case StreamEnd::Late:
      return "LATE";
    case StreamEnd::Revoked:
      return "REVOKED";
  }
  return "?";
}

std::ostream& operator<<(std::ostream& out, StreamEnd end) {
  out << to_string(end);
  switch (end) {
    case StreamEnd::Nothing:
      return out << ": no sample arrived in time; call next() again";
    case StreamEnd::Lost:
      return out << ": the server of the stream is gone or the Lab of the stream is closed; create "
                    "a new proxy and "
                    "subscribe again";
    case StreamEnd::Late:
      return out << ": no sample came within the deadline of the stream; call next() again";
    case StreamEnd::Revoked:
      return out << ": the server no longer admits this user; Stream::loss_text() says why";
  }
  return out;
}

}  // namespace gecos

namespace gecos::session {
namespace {

/// The maximum number of samples that one call of next() reads after its patience has ended, if all
/// these samples are too old. Without this limit, a server that floods the stream with old samples
/// would keep the reader in the call.
constexpr int most_looks = 1024;

}  // namespace

bool ReadPosition::latest(StreamCore& stream) {
  if (copied_) return stream.latest(sample_);
  RawLent lent;
  if (!lend_latest(stream, lent)) return false;
  sample_.bytes.assign(lent.bytes.begin(), lent.bytes.end());
  sample_.stamp_ns = lent.stamp_ns;
  sample_.measured = lent.measured;
  sample_.age = lent.age;
  copied_ = lent.intact();
  return copied_;
}

tl::expected<void, StreamEnd> ReadPosition::next(StreamCore& stream, TimePoint deadline) {
  auto got = stream.next(sample_, deadline);
  copied_ = copied_ || got;
  return got;
}

bool ReadPosition::lend_latest(StreamCore& stream, RawLent& into) {
  into.sequence = sample_.sequence;
  const bool got = stream.lend_latest(into);
  copied_ = copied_ && into.sequence == sample_.sequence;
  sample_.sequence = into.sequence;
  return got;
}

tl::expected<void, StreamEnd> ReadPosition::lend_next(StreamCore& stream, RawLent& into,
                                                      TimePoint deadline) {
  into.sequence = sample_.sequence;
  const auto got = stream.lend_next(into, deadline);
  copied_ = copied_ && into.sequence == sample_.sequence;
  sample_.sequence = into.sequence;
  return got;
}

ClientStream::ClientStream(std::shared_ptr<ClientConnection> session,
                           const StreamDescription& stream,
                           std::unique_ptr<media::StreamReader> reader, std::uint64_t newest,
                           const ClientStream* earlier)
    : session_(std::move(session)),
      code_(stream.code),
      title_("stream '" + std::string(stream.name) + "' of " + session_->object_name()),
      reader_(std::move(reader)),
      opened_at_(newest),
      after_(earlier != nullptr ? earlier->after_
             : stream.event     ? std::optional(newest)
                                : std::nullopt),
      reception_(earlier != nullptr
                     ? earlier->reception_
                     : std::make_shared<qos::Reception>(session_->terms(stream.quality),
                                                        session_->runtime().clock().since_boot(),
                                                        newest, after_)) {}

ClientStream::~ClientStream() { session_->subscriptions().unsubscribe(code_); }

/// Removes the measurement time from the end of `sample`, and sets time and age of the sample. Only
/// a malicious or broken server sends a sample without its measurement time. The bytes of such a
/// sample are removed, so that the sample does not decode.
template <class Raw>
void ClientStream::date(Raw& sample, TimePoint now) {
  constexpr std::int64_t farthest = std::int64_t{1} << 62;
  sample.stamp_ns = std::clamp(sample.stamp_ns, -farthest, farthest);
  const auto measured = take_measured(sample.bytes);
  if (!measured) sample.bytes = {};
  sample.measured = session_->calls().by_our_clock(measured.value_or(TimePoint(-longest_age)));
  sample.age = std::max(now - sample.measured, Duration::zero());
}

/// Sets the time and the age of a sample that was read for the first time. Returns whether the
/// quality of the stream permits giving the sample to the reader.
template <class Raw>
bool ClientStream::admit(qos::Reception::Way way, Raw& sample, TimePoint now) {
  date(sample, now);
  return reception_->take(way, sample.sequence, sample.measured, now);
}

bool ClientStream::latest(RawSample& into) {
  if (lost()) return false;  // after a loss the medium would still return old samples
  const bool unread = reader_->latest(into.sequence, into);
  const TimePoint now = session_->runtime().clock().since_boot();
  if (unread) return admit(qos::Reception::Way::Newest, into, now);
  reception_->find_nothing(now);
  into.age = std::max(now - into.measured, Duration::zero());
  return into.sequence != after_.value_or(0) && reception_->still_valid(now);
}

bool ClientStream::lend_latest(RawLent& into) {
  if (lost()) return false;
  const TimePoint now = session_->runtime().clock().since_boot();
  const std::uint64_t known = into.sequence;
  auto lent = reader_->lend_latest(known == 0 ? 0 : known - 1);
  if (!lent || lent->sequence <= after_.value_or(0)) {
    reception_->find_nothing(now);
    return false;
  }
  static_cast<media::LentSample&>(into) = *std::move(lent);
  if (into.sequence > known) return admit(qos::Reception::Way::Newest, into, now);
  date(into, now);
  reception_->find_nothing(now);
  return reception_->still_valid(now);
}

tl::expected<void, StreamEnd> ClientStream::next(RawSample& into, TimePoint deadline) {
  return next(into, deadline, [&] { return reader_->next(into.sequence, into); });
}

tl::expected<void, StreamEnd> ClientStream::lend_next(RawLent& into, TimePoint deadline) {
  return next(into, deadline, [&] {
    auto lent = reader_->lend_next(into.sequence);
    if (lent) static_cast<media::LentSample&>(into) = *std::move(lent);
    return lent.has_value();
  });
}

template <class Raw>
tl::expected<void, StreamEnd> ClientStream::next(Raw& into, TimePoint deadline,
                                                 FunctionRef<bool()> read) {
  const Clock& clock = session_->runtime().clock();
  for (int looks = most_looks;; --looks) {
    bool got = await_sample(read, deadline);
    // A sample may have come between the last look and the loss of the session.
    if (!got && session_->lost() && !session_->closed()) got = read();
    const TimePoint now = clock.since_boot();
    if (got && came_after_loss(into.sequence)) {
      date(into, now);  // in another session, latest() may return the sample once more
      return tl::unexpected(end());
    }
    if (got) {
      if (admit(qos::Reception::Way::InOrder, into, now)) return {};
      if (looks > 0) continue;
    } else {
      if (!waits_.load(std::memory_order_relaxed)) return tl::unexpected(StreamEnd::Nothing);
      if (lost()) {
        end_with(into.sequence);
        return tl::unexpected(end());
      }
      reception_->find_nothing(now);
      if (reception_->report_late()) return tl::unexpected(StreamEnd::Late);
    }
    if (std::chrono::steady_clock::now() >= deadline) return tl::unexpected(StreamEnd::Nothing);
  }
}

/// Returns whether the sample with the number `sequence`, which is the newest that the caller has
/// read, was published after this stream first found its session lost.
bool ClientStream::came_after_loss(std::uint64_t sequence) {
  if (!lost()) return false;
  if (ends_with_.load(std::memory_order_relaxed) == goes_on) {
    const auto newest = reader_->lend_latest(0);
    end_with(newest ? std::max(newest->sequence, sequence) : sequence);
  }
  return sequence > ends_with_.load(std::memory_order_relaxed);
}

/// Makes the sample with the number `sequence` the last one of the stream, which is lost. Only the
/// first call has an effect.
void ClientStream::end_with(std::uint64_t sequence) {
  std::uint64_t before = goes_on;
  ends_with_.compare_exchange_strong(before, sequence, std::memory_order_relaxed);
}

/// Waits until `deadline` for an unread sample. The wait ends earlier when the deadline of the
/// stream passes without a sample, because the reader must then be told.
bool ClientStream::await_sample(FunctionRef<bool()> read, TimePoint deadline) {
  if (const TimePoint late_at = reception_->late_at(); late_at != TimePoint::max()) {
    const Duration left = late_at - session_->runtime().clock().since_boot();
    deadline = std::min(deadline, TimePoint(std::chrono::steady_clock::now()) + left);
  }
  bool got = false;
  session_->reader().wait(
      nullptr,
      [&] {
        if (session_->closed()) return true;
        const bool ends = session_->lost() || !waits_.load(std::memory_order_relaxed);
        got = got || read();
        return got || ends;
      },
      deadline);
  return got;
}

std::vector<RawSample> ClientStream::history() {
  std::vector<RawSample> kept;
  if (session_->closed()) return kept;
  const TimePoint now = session_->runtime().clock().since_boot();
  auto all = reader_->stored();
  if (!all.empty()) came_after_loss(all.back().sequence);  // the newest one decides the end
  for (media::StreamSample& stored : all) {
    if (stored.sequence <= after_.value_or(0)) continue;  // an event before the subscription
    if (came_after_loss(stored.sequence)) break;
    RawSample sample{std::move(stored), {}, {}};
    date(sample, now);
    if (!reception_->expired(sample.measured, now)) kept.push_back(std::move(sample));
  }
  return kept;
}

void ClientStream::stop_waiting() {
  waits_.store(false, std::memory_order_relaxed);
  session_->reader().wake_all();
}

bool ClientStream::lost() const { return session_->lost() || session_->closed(); }

StreamEnd ClientStream::end() const { return revoked() ? StreamEnd::Revoked : StreamEnd::Lost; }

bool ClientStream::revoked() const {
  return session_->lost() && session_->calls().loss().how == Ending::Revoked;
}

std::string ClientStream::loss_text() const {
  if (!session_->lost()) return {};
  SessionLoss loss = session_->calls().loss();
  return loss.how == Ending::ByUs ? std::string() : std::move(loss.text);
}

}  // namespace gecos::session
