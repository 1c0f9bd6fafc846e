// The log. It writes each message as one line to stderr, for example `gecos warning session: lost
// RX90, asking again`.
//
// The environment variable GECOS_LOG sets the level: error, warning, info or debug. Without
// GECOS_LOG the level is warning. Any thread may log, and the lines of several threads never mix.
// Logging formats text and locks a mutex, so a real-time path must not log. Logging does not wait
// for the reader of stderr: lines that a full pipe does not accept are lost, and the log counts
// them.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace gecos {

enum class LogLevel : std::uint8_t { Error, Warning, Info, Debug };

/// Returns an error text when the value of GECOS_LOG is not a log level. Returns nothing when the
/// value is a level or when GECOS_LOG is not set. The process reads the variable only once.
const std::optional<std::string>& log_level_problem();

namespace detail {
inline constexpr std::uint8_t log_level_unread = 255;
/// The chosen log level, or log_level_unread. This atomic orders no other memory, so relaxed
/// accesses are enough.
inline constinit std::atomic<std::uint8_t> log_level{log_level_unread};
bool read_log_level(LogLevel level);
}  // namespace detail

/// Returns whether the log writes lines of this level. Code that builds a costly text should call
/// this function first: `if (log_enabled(LogLevel::Debug)) …`. When the level is off, the check
/// costs one relaxed load.
inline bool log_enabled(LogLevel level) {
  const std::uint8_t chosen = detail::log_level.load(std::memory_order_relaxed);
  if (static_cast<std::uint8_t>(level) > chosen) return false;
  return chosen != detail::log_level_unread || detail::read_log_level(level);
}

/// Logs `message`. `component` is the name of the module or program that logs, for example
/// "session" or "rx90".
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

/// Sets the log level, whatever GECOS_LOG says; for programs that have an option such as
/// `--verbose`.
void set_log_level(LogLevel level);

/// Returns the log level with the name `name`; nothing when there is no such level.
std::optional<LogLevel> parse_log_level(std::string_view name);

}  // namespace gecos
