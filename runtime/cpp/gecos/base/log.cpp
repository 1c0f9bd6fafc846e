#include "gecos/base/log.hpp"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace gecos {
namespace {

constexpr std::array<std::string_view, 4> level_names{"error", "warning", "info", "debug"};

// fwrite of one whole line: stdio locks the stream, so lines of several threads never mix.
void write_line(LogLevel level, std::string_view component, std::string_view message) {
  std::string line;
  line.reserve(component.size() + message.size() + 20);
  line.append("gecos ").append(level_names[static_cast<std::size_t>(level)]).append(" ");
  line.append(component).append(": ");
  for (const char c : message) line.push_back(c == '\n' || c == '\r' ? ' ' : c);
  line.push_back('\n');
  std::fwrite(line.data(), 1, line.size(), stderr);
}

LogLevel level_from_environment() {
  const char* asked = std::getenv("GECOS_LOG");
  if (asked == nullptr || *asked == '\0') return LogLevel::Warning;
  if (const auto level = parse_log_level(asked)) return *level;
  write_line(LogLevel::Warning, "log",
             std::string("GECOS_LOG is \"") + asked +
                 "\"; it takes error, warning, info or debug. Using warning.");
  return LogLevel::Warning;
}

std::atomic<LogLevel>& chosen_level() {
  static std::atomic<LogLevel> level{level_from_environment()};  // publishes nothing but itself
  return level;
}

}  // namespace

bool log_enabled(LogLevel level) { return level <= chosen_level().load(std::memory_order_relaxed); }

void log(LogLevel level, std::string_view component, std::string_view message) {
  if (log_enabled(level)) write_line(level, component, message);
}

void set_log_level(LogLevel level) { chosen_level().store(level, std::memory_order_relaxed); }

std::optional<LogLevel> parse_log_level(std::string_view name) {
  for (std::size_t i = 0; i < level_names.size(); ++i) {
    if (level_names[i] == name) return static_cast<LogLevel>(i);
  }
  return std::nullopt;
}

}  // namespace gecos
