#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "gecos/base/clock.hpp"

namespace gecos {

/// A thread that reads files. A file system may not answer, for example that of a file server that
/// is down. Then only this thread waits. Thread-safe.
class FileThread {
 public:
  /// `job` reads the files once. It must own all that it uses: while the file system does not
  /// answer, it outlives this object. Throws std::system_error when no thread can be started.
  FileThread(const std::string& name, std::function<void()> job);
  /// Waits until a running job has ended, at most 1 s. A job that takes longer is abandoned.
  ~FileThread();
  FileThread(const FileThread&) = delete;
  FileThread& operator=(const FileThread&) = delete;

  /// Makes the job run once more, soon. Returns the number of a run that begins after this call.
  std::uint64_t ask();
  /// Waits until the run with this number has ended. Returns false if it has not ended after
  /// `patience`, which counts from the beginning of the run that is under way, if one is.
  bool await(std::uint64_t run, Duration patience);

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace gecos
