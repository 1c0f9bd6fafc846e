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

void Repeats::begin(const Key& key, const Line& line) {
  if (runs_.size() < most) runs_.push_back({key, line});
}

std::vector<Line> Repeats::due(std::int64_t now) {
  std::vector<Line> lines;
  std::erase_if(runs_, [&](Run& run) {
    const std::int64_t age = now - run.line.time;
    if (0 <= age && age < window_ms) return false;  // negative: the clock was set back
    if (run.line.count != 0) {
      run.line.time = now;
      lines.push_back(std::move(run.line));
    }
    return true;
  });
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
