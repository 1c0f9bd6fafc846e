#include "gecos/session/server/inward_port.hpp"

#include <algorithm>
#include <utility>

#include "gecos/servant.hpp"
#include "gecos/session/protocol/inward_sample.hpp"
#include "gecos/session/protocol/sample_bounds.hpp"
#include "gecos/session/protocol/sample_time.hpp"

namespace gecos::session {
namespace {

/// Maximum number of refused samples that next_of() reads before it returns. A hostile client may
/// write samples faster than this server refuses them.
std::size_t most_refused_at_once(const InwardDescription& stream) {
  return 2 * (stream.quality.depth != 0 ? stream.quality.depth : usual_depth);
}

}  // namespace

void InwardPort::count(Counts& counts, InwardVerdict verdict) {
  FeedReport& numbers = counts.numbers;
  if (verdict != InwardVerdict::Admitted) {
    counts.last_refusal = verdict;
    counts.unreadable = nullptr;
  }
  switch (verdict) {
    case InwardVerdict::Admitted:
      ++numbers.admitted;
      return;
    case InwardVerdict::OtherSession:
      ++numbers.other_session;
      return;
    case InwardVerdict::SessionEnded:
      ++numbers.session_ended;
      return;
    case InwardVerdict::OtherEpoch:
    case InwardVerdict::NameUnconfirmed:
    case InwardVerdict::NobodyPresent:
      ++numbers.no_status;
      return;
    case InwardVerdict::CommandNotRunning:
      ++numbers.command_not_running;
      return;
    case InwardVerdict::TooOld:
      ++numbers.too_old;
      return;
    case InwardVerdict::NotNewer:
      ++numbers.not_newer;
      return;
  }
}

void InwardPort::add(Counts& to, const Counts& more) {
  to.numbers.admitted += more.numbers.admitted;
  to.numbers.lost += more.numbers.lost;
  to.numbers.other_session += more.numbers.other_session;
  to.numbers.session_ended += more.numbers.session_ended;
  to.numbers.no_status += more.numbers.no_status;
  to.numbers.command_not_running += more.numbers.command_not_running;
  to.numbers.too_old += more.numbers.too_old;
  to.numbers.not_newer += more.numbers.not_newer;
  to.numbers.unreadable += more.numbers.unreadable;
  if (more.last_refusal == InwardVerdict::Admitted && !more.unreadable) return;
  to.last_refusal = more.last_refusal;
  to.unreadable = more.unreadable;
}

/// Converts `counts` to a report with the last refusal in words. The caller must not hold the
/// mutex, because the servant's thread that reads samples would then have to wait for the mutex.
FeedReport InwardPort::in_words(const Counts& counts) {
  FeedReport report = counts.numbers;
  if (counts.unreadable) {
    report.last_refusal = *counts.unreadable;
  } else if (counts.last_refusal != InwardVerdict::Admitted) {
    report.last_refusal = describe(counts.last_refusal);
  }
  return report;
}

InwardPort::Source* InwardPort::find(SessionId session) {
  const auto found = std::ranges::find_if(
      sources_, [&](const auto& source) { return source->feeder.session == session; });
  return found == sources_.end() ? nullptr : found->get();
}

void InwardPort::add(Feeder feeder) {
  const MutexLock lock(mutex_);
  Source* const earlier = find(feeder.session);
  if (earlier == nullptr) {
    sources_.push_back(std::make_unique<Source>(Source{std::move(feeder)}));
    return;
  }
  if (earlier->feeder.reader != nullptr) {
    if (media::StreamSample newest; earlier->feeder.reader->latest(earlier->after, newest)) {
      earlier->counts.numbers.lost += newest.sequence - earlier->after;
    }
  }
  earlier->feeder = std::move(feeder);
  earlier->ended = false;
  earlier->after = 0;
  earlier->admission = {};
}

bool InwardPort::has(SessionId session, std::uint32_t stream) {
  const MutexLock lock(mutex_);
  const Source* const source = find(session);
  return source != nullptr && source->feeder.stream == stream;
}

void InwardPort::end(SessionId session, std::uint32_t stream) {
  const MutexLock lock(mutex_);
  Source* const source = find(session);
  if (source != nullptr && source->feeder.stream == stream) source->ended = true;
}

void InwardPort::depart(SessionId session) {
  const MutexLock lock(mutex_);
  Source* const source = find(session);
  if (source == nullptr) return;
  source->feeder.standing = nullptr;  // the session has ended
  RawInward unread;
  while (next_of(*source, unread, {clock_.since_boot(), Unfed::Refused})) {
  }
  add(gone_, source->counts);
  std::erase_if(sources_, [&](const auto& each) { return each.get() == source; });
}

bool InwardPort::next(RawInward& into, Unfed unfed) {
  const MutexLock lock(mutex_);
  const Look look{clock_.since_boot(), unfed};
  if (pauses_.suspected(look.now) || (moves_the_object() && claim_.waits())) return false;
  for (std::size_t looked = 0; looked < sources_.size(); ++looked) {
    Source& source = *sources_[turn_++ % sources_.size()];
    if (!source.feeder.standing->unheard() && next_of(source, into, look)) return true;
  }
  return false;
}

bool InwardPort::next_of(Source& source, RawInward& into, const Look& look) {
  if (source.feeder.reader == nullptr) return false;
  for (std::size_t read = 0; read < most_refused_at_once(stream_); ++read) {
    if (!source.feeder.reader->next(source.after, into.sample)) {
      if (source.ended) source.feeder.reader = nullptr;
      return false;
    }
    source.counts.numbers.lost += into.sample.sequence - source.after - 1;
    source.after = into.sample.sequence;
    const InwardVerdict verdict = judge(source, into, look);
    count(source.counts, verdict);
    if (verdict == InwardVerdict::Admitted) return true;
  }
  return false;
}

InwardVerdict InwardPort::judge(Source& source, RawInward& into, const Look& look) {
  const auto measured = take_measured(into.sample.bytes);
  const auto sample = read_inward_sample(into.sample.bytes);
  // Only a defective or hostile client sends a sample without a header.
  if (!measured || !sample) return InwardVerdict::OtherSession;
  const TimePoint by_our_clock = std::min(*measured + source.feeder.clock_difference(), look.now);
  InwardAge age{look.now - by_our_clock};
  for (const Duration limit : {stream_.watchdog, stream_.quality.lifespan}) {
    if (limit > Duration{}) age.limit = std::min(age.limit, limit);
  }
  const InwardVerdict verdict =
      source.admission.judge(sample->header, into.sample.sequence,
                             sender_of(source, sample->header, by_our_clock, look), age);
  if (verdict != InwardVerdict::Admitted) return verdict;
  fresh_before_ = fresh_at_;
  fresh_at_ = fresh_at_ ? std::max(*fresh_at_, by_our_clock) : by_our_clock;
  into.value = sample->value;
  into.age = age.age;
  into.session = number(sample->header.session);
  into.command = sample->header.command;
  return verdict;
}

InwardSender InwardPort::sender_of(const Source& source, const InwardHeader& header, TimePoint sent,
                                   const Look& look) const {
  InwardSender sender;
  sender.session = source.feeder.session;
  sender.alive = source.feeder.standing != nullptr;
  if (sender.alive) sender.epoch = source.feeder.standing->epoch(stream_.status);
  // A stream that needs no status has no epoch, so the epoch is not checked.
  if (sender.epoch && !moves_the_object()) sender.epoch = header.epoch;
  sender.name_unconfirmed = moves_the_object() && claim_.refuses();
  sender.nobody_present =
      moves_the_object() && stream_.presence && !presence_.present_since(sent, look.now);
  sender.feeding = fed_by(sender.session, look.unfed);
  return sender;
}

/// Returns the counter of the command that takes samples of `session`. Returns 0 if samples without
/// a command are admitted, and nullopt if no samples are admitted.
std::optional<std::uint64_t> InwardPort::fed_by(SessionId session, Unfed unfed) const {
  if (fed_.empty()) return unfed == Unfed::Taken ? std::optional(std::uint64_t{0}) : std::nullopt;
  const CallCore& call = *fed_.back().call;
  if (call.interrupted() || SessionId{call.caller().session} != session) return std::nullopt;
  return call.counter_in_session();
}

void InwardPort::unreadable(const RawInward& sample, const std::string& why) {
  auto text = std::make_shared<const std::string>(why);
  const MutexLock lock(mutex_);
  fresh_at_ = fresh_before_;
  Source* const source = find(SessionId{sample.session});
  Counts& counts = source != nullptr ? source->counts : gone_;
  --counts.numbers.admitted;
  ++counts.numbers.unreadable;
  counts.unreadable.swap(text);
}

bool InwardPort::expired_now() const {
  if (stream_.watchdog <= Duration{}) return false;
  return !fresh_at_ || clock_.since_boot() - *fresh_at_ > stream_.watchdog;
}

bool InwardPort::expired() {
  const MutexLock lock(mutex_);
  return expired_now();
}

FeedReport InwardPort::report_of(SessionId session) {
  Counts counts;
  {
    const MutexLock lock(mutex_);
    const Source* const source = find(session);
    if (source == nullptr) return {};
    counts = source->counts;
    counts.numbers.expired = expired_now();
  }
  return in_words(counts);
}

FeedReport InwardPort::report() {
  Counts counts;
  {
    const MutexLock lock(mutex_);
    counts = gone_;
    for (const auto& source : sources_) add(counts, source->counts);
    counts.numbers.expired = expired_now();
  }
  return in_words(counts);
}

std::uint64_t InwardPort::begin_feeding(std::shared_ptr<const CallCore> call) {
  const MutexLock lock(mutex_);
  fed_.push_back({++feedings_, std::move(call)});
  fresh_at_ = clock_.since_boot();
  return feedings_;
}

void InwardPort::end_feeding(std::uint64_t feeding) {
  const MutexLock lock(mutex_);
  std::erase_if(fed_, [&](const Feeding& each) { return each.number == feeding; });
}

}  // namespace gecos::session
