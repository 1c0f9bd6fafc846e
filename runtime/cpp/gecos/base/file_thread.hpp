#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "gecos/base/clock.hpp"

namespace gecos {

/// A thread that reads files, so that only this thread waits when a file system does not answer,
/// for example because a file server is down. Thread-safe.
class FileThread {
 public:
  /// `job` reads the files once. `job` must own everything that it uses, because it may still run
  /// after the end of this object if the file system does not answer. Throws std::system_error when
  /// no thread can be started.
  FileThread(const std::string& name, std::function<void()> job);
  /// Waits until a running job has ended, at most 1 s. A job that takes longer is abandoned.
  ~FileThread();
  FileThread(const FileThread&) = delete;
  FileThread& operator=(const FileThread&) = delete;

  /// Makes the job run once more, soon. Returns the number of a run that begins after this call.
  std::uint64_t ask();
  /// Waits until the run with this number has ended. Returns false if the run has not ended after
  /// `patience`. If an earlier run has not ended yet, `patience` counts from the beginning of that
  /// run, but the wait takes at least 25 ms. If this process stands still meanwhile, for example
  /// after SIGSTOP, the pause does not count, except for its first 25 ms.
  bool await(std::uint64_t run, Duration patience);

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace gecos
