#include "gecos/audit/repeats.hpp"

#include <algorithm>
#include <limits>

namespace gecos::audit {

bool Repeats::count(const Key& key, std::uint64_t counter) {
  for (Run& run : runs_) {
    if (run.key != key) continue;
    if (run.line.count++ == 0) run.line.request.counter = counter;
    run.line.last = counter;
    return true;
  }
  return false;
}

void Repeats::begin(const Key& key, const Line& line, Window window) {
  if (runs_.size() < most_) runs_.push_back({key, line, window});
}

bool Repeats::end_window(Run& run, std::int64_t now, std::vector<Line>& lines) {
  const std::int64_t age = now - run.line.time;
  const bool set_back = age < 0;  // the clock was
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
  std::erase_if(runs_, [&](Run& run) { return end_window(run, now, lines); });
  return lines;
}

std::vector<Line> Repeats::all() {
  std::vector<Line> lines;
  for (Run& run : runs_) {
    if (run.line.count != 0) lines.push_back(std::move(run.line));
  }
  runs_.clear();
  return lines;
}

}  // namespace gecos::audit
