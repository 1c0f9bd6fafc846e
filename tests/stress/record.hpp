// A log of a program's actions, line by line, in a file that survives the kill of the program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace stress {

/// Each line is one write to the end of the file: it is there as soon as `note` returns, and whole.
/// It begins with CLOCK_BOOTTIME in ns, the same for all programs of a host. Thread-safe.
class Record {
 public:
  explicit Record(const std::string& path);
  ~Record();
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  void note(const std::string& what) const;

 private:
  int file_;
};

/// The workbench's answer to a command; it distinguishes the command from all others.
std::int64_t answer(std::uint64_t command, std::int64_t salt);
std::int64_t answer(std::uint64_t command, std::span<const std::uint8_t> load);

/// The open resources of this process.
struct Census {
  std::ptrdiff_t descriptors = 0;
  std::ptrdiff_t threads = 0;
  std::ptrdiff_t memfds = 0;  ///< that are mapped

  friend bool operator==(const Census&, const Census&) = default;
};
Census census();
/// Says "before …" now, and "after …" when it is told to, once as much is open as at its beginning,
/// else after ten seconds: a thread that lets go of the last session ends a moment later.
class Balance {
 public:
  Balance();
  void close() const;

 private:
  static Census at_first();
  const Census before_ = at_first();
};

}  // namespace stress
