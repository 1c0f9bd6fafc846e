#include "gecos/audit/repeats.hpp"

#include <algorithm>
#include <utility>

namespace gecos::audit {

std::int64_t Repeats::Run::due() const {
  const bool kept = window == Window::Growing && line.count == 0;
  return line.time + (kept ? longest_window_ms : length);
}

void Repeats::note_times(const Run& run) {
  next_due_ = std::min(next_due_, run.due());
  newest_ = std::max(newest_, run.line.time);
}

bool Repeats::count(const Key& key, std::uint64_t counter) {
  const auto found = std::ranges::find(keys_, key);
  if (found == keys_.end()) return false;
  Run& run = runs_[static_cast<std::size_t>(found - keys_.begin())];
  run.line.last = counter;
  if (run.line.count++ != 0) return true;
  run.line.request.counter = counter;
  note_times(run);
  return true;
}

void Repeats::begin(const Key& key, const Line& line, Window window) {
  if (runs_.size() >= most_) return;
  keys_.push_back(key);
  note_times(runs_.emplace_back(Run{line, window}));
}

bool Repeats::end_window(Run& run, std::int64_t now, std::vector<Line>& lines) {
  const std::int64_t age = now - run.line.time;
  const bool set_back = age < 0;  // the clock was set back
  if (!set_back && age < run.length) return false;
  const bool quiet = run.line.count == 0;
  if (run.window == Window::Growing && quiet) return set_back || age >= longest_window_ms;
  if (quiet) return true;
  run.line.time = now;
  lines.push_back(run.line);
  run.line.count = 0;
  run.line.last = 0;
  run.length = std::min(2 * run.length, longest_window_ms);
  return run.window == Window::OneSecond;
}

std::vector<Line> Repeats::due(std::int64_t now) {
  std::vector<Line> lines;
  if (newest_ <= now && now < next_due_) return lines;
  next_due_ = std::numeric_limits<std::int64_t>::max();
  newest_ = std::numeric_limits<std::int64_t>::min();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (end_window(runs_[i], now, lines)) continue;
    note_times(runs_[i]);
    if (kept != i) {
      keys_[kept] = std::move(keys_[i]);
      runs_[kept] = std::move(runs_[i]);
    }
    ++kept;
  }
  keys_.resize(kept);
  runs_.resize(kept);
  return lines;
}

std::vector<Line> Repeats::all(std::int64_t now) {
  std::vector<Line> lines;
  for (Run& run : runs_) {
    if (run.line.count == 0) continue;
    run.line.time = now;
    lines.push_back(std::move(run.line));
  }
  keys_.clear();
  runs_.clear();
  return lines;
}

}  // namespace gecos::audit
