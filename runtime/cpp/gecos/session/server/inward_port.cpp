#include "gecos/session/server/inward_port.hpp"

#include <algorithm>
#include <utility>

#include "gecos/session/protocol/inward_sample.hpp"
#include "gecos/session/protocol/sample_time.hpp"

namespace gecos::session {
namespace {

constexpr std::size_t usual_depth = 16;

/// A hostile client may write samples faster than they are refused, so one look reads at most so
/// many.
std::size_t most_refused_at_once(const InwardDescription& stream) {
  return 2 * (stream.quality.depth != 0 ? stream.quality.depth : usual_depth);
}

void count(FeedReport& counts, InwardVerdict verdict) {
  switch (verdict) {
    case InwardVerdict::Admitted:
      ++counts.admitted;
      return;
    case InwardVerdict::OtherSession:
      ++counts.other_session;
      return;
    case InwardVerdict::SessionEnded:
      ++counts.session_ended;
      return;
    case InwardVerdict::OtherEpoch:
      ++counts.no_status;
      return;
    case InwardVerdict::CommandNotRunning:
      ++counts.command_not_running;
      return;
    case InwardVerdict::TooOld:
      ++counts.too_old;
      return;
    case InwardVerdict::NotNewer:
      ++counts.not_newer;
      return;
  }
}

void add(FeedReport& to, const FeedReport& more) {
  to.admitted += more.admitted;
  to.lost += more.lost;
  to.other_session += more.other_session;
  to.session_ended += more.session_ended;
  to.no_status += more.no_status;
  to.command_not_running += more.command_not_running;
  to.too_old += more.too_old;
  to.not_newer += more.not_newer;
  to.unreadable += more.unreadable;
  if (!more.last_refusal.empty()) to.last_refusal = more.last_refusal;
}

}  // namespace

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
      earlier->counts.lost += newest.sequence - earlier->after;
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
  while (next_of(*source, unread, Unfed::Refused)) {
  }
  gecos::session::add(gone_, counts_of(*source));
  std::erase_if(sources_, [&](const auto& each) { return each.get() == source; });
}

bool InwardPort::next(RawInward& into, Unfed unfed) {
  const MutexLock lock(mutex_);
  for (std::size_t looked = 0; looked < sources_.size(); ++looked) {
    Source& source = *sources_[turn_++ % sources_.size()];
    if (next_of(source, into, unfed)) return true;
  }
  return false;
}

bool InwardPort::next_of(Source& source, RawInward& into, Unfed unfed) {
  if (source.feeder.reader == nullptr) return false;
  for (std::size_t read = 0; read < most_refused_at_once(stream_); ++read) {
    if (!source.feeder.reader->next(source.after, into.sample)) {
      if (source.ended) source.feeder.reader = nullptr;
      return false;
    }
    source.counts.lost += into.sample.sequence - source.after - 1;
    source.after = into.sample.sequence;
    const InwardVerdict verdict = judge(source, into, unfed);
    count(source.counts, verdict);
    if (verdict == InwardVerdict::Admitted) return true;
    source.last_refusal = verdict;
    source.counts.last_refusal.clear();
  }
  return false;
}

InwardVerdict InwardPort::judge(Source& source, RawInward& into, Unfed unfed) {
  const auto measured = take_measured(into.sample.bytes);
  const auto sample = read_inward_sample(into.sample.bytes);
  // Only a defective or hostile client sends a sample without a header.
  if (!measured || !sample) return InwardVerdict::OtherSession;
  const TimePoint now = clock_.since_boot();
  const TimePoint by_our_clock = std::min(*measured + source.feeder.clock_difference(), now);
  InwardAge age{now - by_our_clock};
  if (stream_.watchdog > Duration{}) age.limit = stream_.watchdog;
  const InwardVerdict verdict = source.admission.judge(
      sample->header, into.sample.sequence, sender_of(source, sample->header, unfed), age);
  if (verdict != InwardVerdict::Admitted) return verdict;
  fresh_before_ = fresh_at_;
  fresh_at_ = fresh_at_ ? std::max(*fresh_at_, by_our_clock) : by_our_clock;
  into.value = sample->value;
  into.age = age.age;
  into.session = number(sample->header.session);
  into.command = sample->header.command;
  return verdict;
}

InwardSender InwardPort::sender_of(const Source& source, const InwardHeader& header,
                                   Unfed unfed) const {
  InwardSender sender;
  sender.session = source.feeder.session;
  sender.alive = source.feeder.standing != nullptr;
  if (sender.alive) sender.epoch = source.feeder.standing->epoch(stream_.status);
  // A stream that needs no status is not fenced by an epoch.
  if (sender.epoch && stream_.status == access::Status::Sensor) sender.epoch = header.epoch;
  if (fed_) {
    if (fed_->session == sender.session) sender.feeding = fed_->counter;
  } else if (unfed == Unfed::Taken) {
    sender.feeding = 0;
  }
  return sender;
}

void InwardPort::unreadable(const RawInward& sample, const std::string& why) {
  const MutexLock lock(mutex_);
  fresh_at_ = fresh_before_;
  Source* const source = find(SessionId{sample.session});
  FeedReport& counts = source != nullptr ? source->counts : gone_;
  --counts.admitted;
  ++counts.unreadable;
  counts.last_refusal = why;
}

bool InwardPort::expired_now() const {
  if (stream_.watchdog <= Duration{}) return false;
  return !fresh_at_ || clock_.since_boot() - *fresh_at_ > stream_.watchdog;
}

bool InwardPort::expired() {
  const MutexLock lock(mutex_);
  return expired_now();
}

/// The text of a refusal is made only here, so that refusing allocates nothing.
FeedReport InwardPort::counts_of(const Source& source) const {
  FeedReport report = source.counts;
  if (report.last_refusal.empty() && source.last_refusal != InwardVerdict::Admitted) {
    report.last_refusal = describe(source.last_refusal);
  }
  report.expired = expired_now();
  return report;
}

FeedReport InwardPort::report_of(SessionId session) {
  const MutexLock lock(mutex_);
  const Source* const source = find(session);
  return source != nullptr ? counts_of(*source) : FeedReport{};
}

FeedReport InwardPort::report() {
  const MutexLock lock(mutex_);
  FeedReport report = gone_;
  for (const auto& source : sources_) gecos::session::add(report, counts_of(*source));
  report.expired = expired_now();
  return report;
}

void InwardPort::feed_command(std::uint64_t session, std::uint64_t counter) {
  const MutexLock lock(mutex_);
  fed_ = Command{SessionId{session}, counter};
  fresh_at_ = clock_.since_boot();
}

void InwardPort::feed_no_command() {
  const MutexLock lock(mutex_);
  fed_.reset();
}

}  // namespace gecos::session
