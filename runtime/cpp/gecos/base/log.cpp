#include "gecos/base/log.hpp"

#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <utility>

#include "gecos/base/mutex.hpp"
#include "gecos/base/whole_characters.hpp"

namespace gecos {
namespace {

constexpr std::array<std::string_view, 4> level_names{"error", "warning", "info", "debug"};

/// Writes whole lines to stderr. Lines of several threads never mix, and no thread waits when
/// nobody reads stderr. Lines that a full pipe does not accept are lost; the log reports their
/// number as soon as the pipe is read again.
class Stderr {
 public:
  static Stderr& instance() {
    static Stderr& out = *new Stderr;  // outlives every static that may still log
    return out;
  }

  void write_line(std::string line) {
    const MutexLock lock(mutex_);
    const bool told = lost_ == 0 || write("gecos warning log: " + std::to_string(lost_) +
                                          " lines were lost because nobody read stderr\n");
    if (told) lost_ = 0;
    if (!told || !write(shortened(std::move(line)))) ++lost_;
  }

 private:
  /// The largest number of bytes that a pipe always accepts in one write() when poll() reports the
  /// pipe as writable.
  static constexpr std::size_t longest = PIPE_BUF;

  Stderr() {  // a forked child must find the mutex unlocked
    ::pthread_atfork(before_fork, after_fork, after_fork);
  }

  // before_fork() locks the mutex and after_fork() unlocks it. The thread-safety analysis cannot
  // follow this.
  static void before_fork() GECOS_NOT_ANALYSED { instance().mutex_.lock(); }
  static void after_fork() GECOS_NOT_ANALYSED { instance().mutex_.unlock(); }

  /// Returns the text `line`. If the text is too long, its middle is left out, because the two ends
  /// of a stack trace say most.
  static std::string shortened(std::string line) {
    constexpr std::string_view gap = " … ";
    if (line.size() <= longest) return line;
    const std::size_t begin = whole_characters(line, longest / 2).size();
    std::size_t end = line.size() - (longest - longest / 2 - gap.size());
    while (whole_characters(line, end).size() != end) ++end;
    return line.replace(begin, end - begin, gap);
  }

  static bool write(std::string_view line) {
    pollfd watched{STDERR_FILENO, POLLOUT, 0};
    if (::poll(&watched, 1, 0) != 1 || (watched.revents & (POLLERR | POLLNVAL)) != 0) return false;
    return ::write(STDERR_FILENO, line.data(), line.size()) >= 0;
  }

  Mutex mutex_;
  std::size_t lost_ GECOS_GUARDED_BY(mutex_) = 0;
};

void write_line(LogLevel level, std::string_view component, std::string_view message) {
  std::string line;
  line.reserve(component.size() + message.size() + 20);
  line.append("gecos ").append(level_names[static_cast<std::size_t>(level)]).append(" ");
  line.append(component).append(": ");
  for (const char c : message) line.push_back(c == '\n' || c == '\r' ? ' ' : c);
  line.push_back('\n');
  Stderr::instance().write_line(std::move(line));
}

/// The log level that the environment variable GECOS_LOG sets, or an error text when its value is
/// not a log level.
struct Asked {
  LogLevel level = LogLevel::Warning;
  std::optional<std::string> problem;
};

Asked ask_environment() {
  const char* const asked = std::getenv("GECOS_LOG");
  if (asked == nullptr || *asked == '\0') return {};
  if (const auto level = parse_log_level(asked)) return {*level, {}};
  return {LogLevel::Warning,
          "GECOS_LOG is \"" + std::string(asked) +
              "\", which is not a log level; write error, warning, info or debug"};
}

const Asked& environment() {
  static const Asked& asked = *new Asked(ask_environment());  // outlives every static that may log
  return asked;
}

}  // namespace

const std::optional<std::string>& log_level_problem() { return environment().problem; }

bool detail::read_log_level(LogLevel level) {
  std::uint8_t unread = log_level_unread;  // the exchange keeps a level from set_log_level()
  log_level.compare_exchange_strong(unread, static_cast<std::uint8_t>(environment().level),
                                    std::memory_order_relaxed);
  return log_enabled(level);
}

void log(LogLevel level, std::string_view component, std::string_view message) {
  if (log_enabled(level)) write_line(level, component, message);
}

void set_log_level(LogLevel level) {
  detail::log_level.store(static_cast<std::uint8_t>(level), std::memory_order_relaxed);
}

std::optional<LogLevel> parse_log_level(std::string_view name) {
  for (std::size_t i = 0; i < level_names.size(); ++i) {
    if (level_names[i] == name) return static_cast<LogLevel>(i);
  }
  return std::nullopt;
}

}  // namespace gecos
