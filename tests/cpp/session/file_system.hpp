// The system in the hands of the test: open() and read() of this program obey the objects below.
#pragma once

#include <functional>
#include <string>

namespace probe {

/// While it lives, open() of a file whose path contains `part` does not return. One at a time.
class HangingFiles {
 public:
  explicit HangingFiles(const std::string& part);
  ~HangingFiles();
  HangingFiles(const HangingFiles&) = delete;
  HangingFiles& operator=(const HangingFiles&) = delete;
  /// Waits until a thread opens such a file.
  void await_reader();
};

/// Calls `action` once, at the next open() of the file, before the file is opened.
void at_next_open(const std::string& path, std::function<void()> action);
/// Calls `action` once, between the next open() of the file and its first read().
void at_next_read(const std::string& path, std::function<void()> action);

}  // namespace probe
