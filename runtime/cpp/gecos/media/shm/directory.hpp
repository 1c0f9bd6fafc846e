#pragma once

#include <string>

#include "gecos/media/descriptor.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media::shm {

/// `GECOS_RUNTIME_DIR`, else /run/gecos where an administrator made one for all users (root's,
/// sticky), else one for this user alone, /tmp/gecos-<uid>. The only look at the environment here.
std::string default_runtime_directory();

/// Makes `directory` (0700) if nothing is there, and checks that no other user could put sockets of
/// theirs in place of ours.
tl::expected<void, MediumError> prepare_directory(const std::string& directory);

/// True when several users meet in `directory`.
bool shared_between_users(const std::string& directory);

/// What is equal exactly where programs reach each other over shm through `directory`: the boot id
/// of the kernel and the inode of the directory, "6b0c…-…/2049:131".
tl::expected<std::string, MediumError> host_identity(const std::string& directory);

/// Held while sockets come and go in the directory, so that nobody removes one between its making
/// and its first listening.
class DirectoryLock {
 public:
  /// Waits at most a second for whoever holds it.
  static tl::expected<DirectoryLock, MediumError> take(const std::string& directory);

 private:
  explicit DirectoryLock(Descriptor held) : held_(std::move(held)) {}
  Descriptor held_;
};

}  // namespace gecos::media::shm
