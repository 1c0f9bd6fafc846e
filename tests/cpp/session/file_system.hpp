// The system in the hands of the test: open(), read() and pthread_create() of this program obey the
// objects below.
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

/// While it lives, this process can start no thread.
class NoThreads {
 public:
  NoThreads();
  ~NoThreads();
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;
  /// Waits until it could not start one.
  void await_try();
};

/// Calls `action` once, at the next open() of the file, before the file is opened.
void at_next_open(const std::string& path, std::function<void()> action);
/// Calls `action` once, between the next open() of the file and its first read().
void at_next_read(const std::string& path, std::function<void()> action);

}  // namespace probe
