#pragma once

#include <string>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media::shm {

/// The directory with the sockets of this user's programs: `GECOS_RUNTIME_DIR`, else /run/gecos if
/// an administrator made it, else /tmp. In a directory that all users share (owned by root and
/// sticky), each user has a folder gecos-<uid>, because a common folder would belong to the user
/// who came first. No other function of shm reads the environment.
std::string default_runtime_directory();

/// Makes `directory` (0700) if nothing is there. Checks that its path leaves room for the names of
/// sockets and that no other user could replace our sockets.
tl::expected<void, MediumError> prepare_directory(const std::string& directory);

/// A text that is equal in two programs if and only if they reach each other over shm through
/// `directory`: the boot id of the kernel and the inode of the directory, "6b0c…-…/2049:131".
tl::expected<std::string, MediumError> host_identity(const std::string& directory);

/// A lock that is held while sockets are made and removed in the directory, so that no process
/// removes a socket between its bind and its listen.
class DirectoryLock {
 public:
  /// Waits at most a second for another process that holds the lock.
  static tl::expected<DirectoryLock, MediumError> take(const std::string& directory);

 private:
  explicit DirectoryLock(Descriptor held) : held_(std::move(held)) {}
  Descriptor held_;
};

}  // namespace gecos::media::shm
