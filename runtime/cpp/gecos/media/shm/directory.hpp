#pragma once

#include <string>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media::shm {

/// Returns the directory with the sockets of this user's programs. This is the directory in the
/// environment variable `GECOS_RUNTIME_DIR`, else /run/gecos if an administrator made it, else
/// /tmp. If all users share that directory (it is owned by root and sticky), the result is the
/// folder gecos-<uid> in it: a common folder would belong to its first user. No other function of
/// shm reads the environment.
std::string default_runtime_directory();

/// Creates `directory` with the mode 0700 if it does not exist. Checks that its path is short
/// enough for the paths of sockets in it, and that no other user can replace the sockets.
tl::expected<void, MediumError> prepare_directory(const std::string& directory);

/// Returns the boot id of the kernel, for example "6b0c…-…"; an empty text when the kernel does not
/// tell it.
std::string kernel_boot();

/// Prepares `directory`, and returns a text that identifies it on this machine by its inode, for
/// example "2049:131".
tl::expected<std::string, MediumError> directory_identity(const std::string& directory);

/// The lock of a runtime directory. A process holds it while it makes or removes sockets in the
/// directory. So no other process removes a socket between its bind() and its listen().
class DirectoryLock {
 public:
  /// Takes the lock. Waits at most one second if another process holds the lock.
  static tl::expected<DirectoryLock, MediumError> take(const std::string& directory);

 private:
  explicit DirectoryLock(Descriptor held) : held_(std::move(held)) {}
  Descriptor held_;
};

}  // namespace gecos::media::shm
