#pragma once

#include <string>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media::shm {

/// The directory in which the programs of this user find each other: `GECOS_RUNTIME_DIR`, else
/// /run/gecos where an administrator made it, else /tmp. Each user has a folder gecos-<uid> in a
/// directory that all users share (one of root's that is sticky): a shared place for sockets would
/// belong to the user who came first. Only this function reads the environment here.
std::string default_runtime_directory();

/// Makes `directory` (0700) if nothing is there. Checks that its path leaves room for the names of
/// sockets and that no other user could put sockets of theirs in place of ours.
tl::expected<void, MediumError> prepare_directory(const std::string& directory);

/// What is equal exactly where programs reach each other over shm through `directory`: the boot id
/// of the kernel and the inode of the directory, "6b0c…-…/2049:131".
tl::expected<std::string, MediumError> host_identity(const std::string& directory);

/// Held while sockets are made and removed in the directory, so that no process removes a socket
/// between its bind and its listen.
class DirectoryLock {
 public:
  /// Waits at most a second for the process that holds it.
  static tl::expected<DirectoryLock, MediumError> take(const std::string& directory);

 private:
  explicit DirectoryLock(Descriptor held) : held_(std::move(held)) {}
  Descriptor held_;
};

}  // namespace gecos::media::shm
