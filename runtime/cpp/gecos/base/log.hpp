// One line per message on stderr: `gecos warning session: lost RX90, asking again`.
//
// GECOS_LOG=error|warning|info|debug sets the level; unset means warning. Any thread may log; lines
// never mix. Logging formats and locks, so a real-time path must not log. Logging does not wait for
// the reader of stderr: lines that a full pipe does not accept are lost, and counted.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace gecos {

enum class LogLevel : std::uint8_t { Error, Warning, Info, Debug };

/// Why the value of GECOS_LOG is not a log level; nothing when the value is a level or is not set.
/// The variable is read once.
const std::optional<std::string>& log_level_problem();

namespace detail {
inline constexpr std::uint8_t log_level_unread = 255;
/// The chosen level. Orders no other memory: relaxed is enough.
inline constinit std::atomic<std::uint8_t> log_level{log_level_unread};
bool read_log_level(LogLevel level);
}  // namespace detail

/// Whether lines of this level are written, to skip costly texts: `if
/// (log_enabled(LogLevel::Debug)) …`. One relaxed load when they are not.
inline bool log_enabled(LogLevel level) {
  const std::uint8_t chosen = detail::log_level.load(std::memory_order_relaxed);
  if (static_cast<std::uint8_t>(level) > chosen) return false;
  return chosen != detail::log_level_unread || detail::read_log_level(level);
}

/// `component` is the module or program that logs: "session", "rx90".
void log(LogLevel level, std::string_view component, std::string_view message);

inline void log_error(std::string_view component, std::string_view message) {
  log(LogLevel::Error, component, message);
}
inline void log_warning(std::string_view component, std::string_view message) {
  log(LogLevel::Warning, component, message);
}
inline void log_info(std::string_view component, std::string_view message) {
  log(LogLevel::Info, component, message);
}
inline void log_debug(std::string_view component, std::string_view message) {
  log(LogLevel::Debug, component, message);
}

/// Overrides GECOS_LOG, for programs with a `--verbose`.
void set_log_level(LogLevel level);

/// The level called `name`; nothing when there is no such level.
std::optional<LogLevel> parse_log_level(std::string_view name);

}  // namespace gecos
