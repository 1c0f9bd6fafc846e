#include "gecos/session/server/call_statistics.hpp"

#include <algorithm>

#include "gecos/base/seconds.hpp"
#include "gecos/session/server/server_call.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

std::vector<OutcomeCount> CallCounts::outcomes() const {
  std::vector<OutcomeCount> counted;
  for (std::size_t detail = 0; detail < ended.size(); ++detail) {
    if (ended[detail] != 0) counted.push_back({static_cast<std::uint8_t>(detail), ended[detail]});
  }
  return counted;
}

void CallStatistics::queued(ServerCall& call) { call.counts = &of(call.operation()); }

void CallStatistics::begins(ServerCall& call, TimePoint since_boot, bool long_running) {
  CallCounts& counts = call.counts->calls;
  if (long_running) {
    call.timing = {since_boot, 1};
  } else if (const auto weight = timed_weight(counts.begun); weight != 0) {
    call.timing = {clock_.since_boot(), weight};
  }
  ++counts.begun;
  ++call.session->counts.begun;
}

void CallStatistics::runs_long(ServerCall& call) {
  HandlerTiming& timing = call.timing;
  if (timing.weight == 0) timing.from = *call.state.begun_at();
  timing.weight = 1;  // every handler that runs this long is timed
}

void CallStatistics::ended(ServerCall& call, Detail detail) {
  CallCounts& of_operation = call.counts->calls;
  CallCounts& of_session = call.session->counts;
  of_operation.count_end(detail);
  of_session.count_end(detail);
  if (detail != Detail::Expired && detail != Detail::TimedOut) return;
  const TimePoint now = clock_.since_boot();
  if (!call.state.overdue(now)) return;  // the handler itself has answered with this detail
  const auto missed =
      call.state.misses_start(now) ? &CallCounts::start_by_missed : &CallCounts::deadline_missed;
  ++(of_operation.*missed);
  ++(of_session.*missed);
}

void CallStatistics::finished(ServerCall& call) {
  const auto [from, weight] = call.timing;
  if (weight != 0) call.counts->times.add(clock_.since_boot() - from, weight);
}

void CallStatistics::refused(ServerSession& session, const OperationDescription* operation,
                             Detail detail) {
  session.counts.count_end(detail);
  if (operation != nullptr) of(*operation).calls.count_end(detail);
}

void CallStatistics::find(const OperationDescription& operation) {
  auto& counts = operations_[&operation];
  if (!counts) counts = std::make_unique<OperationCounts>();
  last_ = &operation;
  last_counts_ = counts.get();
}

std::vector<OperationStats> CallStatistics::shown() const {
  std::vector<OperationStats> all;
  for (const auto& [operation, counts] : operations_) {
    const auto& [calls, times] = *counts;
    OperationStats stats;
    stats.operation = operation->name;
    stats.begun = calls.begun;
    stats.ended = calls.outcomes();
    stats.deadline_missed = calls.deadline_missed;
    stats.start_by_missed = calls.start_by_missed;
    stats.median = to_seconds(times.quantile(0.5));
    stats.percentile_99 = to_seconds(times.quantile(0.99));
    stats.worst = to_seconds(times.worst());
    all.push_back(std::move(stats));
  }
  std::ranges::sort(all, {}, &OperationStats::operation);
  return all;
}

}  // namespace gecos::session
