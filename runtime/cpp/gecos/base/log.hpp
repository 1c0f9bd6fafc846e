// One line per message on stderr: `gecos warning session: lost RX90, asking again`.
//
// GECOS_LOG=error|warning|info|debug chooses how much; unset means warning. Any thread may log,
// lines never mix. It formats and locks, so never on a real-time path; it does not wait for who
// reads: what a full pipe does not take is lost, and counted.
#pragma once

#include <optional>
#include <string_view>

namespace gecos {

enum class LogLevel { Error, Warning, Info, Debug };

/// For skipping costly texts: `if (log_enabled(LogLevel::Debug)) …`.
bool log_enabled(LogLevel level);

/// `component` is the room or program that speaks: "session", "rx90".
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

/// The level of that name; nothing for any other word.
std::optional<LogLevel> parse_log_level(std::string_view name);

}  // namespace gecos
