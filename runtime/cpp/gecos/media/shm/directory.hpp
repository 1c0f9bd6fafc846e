#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media::shm {

/// Returns the directory with the sockets of this user's programs. This is the directory in the
/// environment variable `GECOS_RUNTIME_DIR`, else /run/gecos if an administrator made that
/// directory, else /tmp. If all users share the directory (root owns it, and it is sticky), the
/// result is the folder gecos-<uid> in the directory, because a folder that several users share
/// would belong to the user who made it. No other function of shm reads the environment.
std::string default_runtime_directory();

/// Returns whether `uid` is root or the user `gecos`. If an administrator made a shared directory
/// for sockets, the programs of these two users serve all users of the host, and the programs of
/// other users trust these programs.
bool serves_the_host(std::uint32_t uid);
/// Returns whether `user` is the name of root or of the user `gecos`. The name need not be known on
/// this host.
bool serves_the_host(std::string_view user);

/// Returns whether the programs of all users can reach the sockets in `directory`, a directory of
/// this user. They can if this user is root or `gecos`, and `directory` is this user's folder in a
/// directory that an administrator made for all users: a directory that is owned by root and
/// sticky, but not /tmp.
bool open_to_all_users(const std::string& directory);

/// Returns the directories in which this program may look for servers of other users. These are the
/// folders of root and of the user `gecos` beside `directory`, if they exist and are open to all
/// users.
std::vector<std::string> directories_of_the_host(const std::string& directory);

/// Creates `directory` if it does not exist, with the mode 0711 if it is open to all users and with
/// 0700 otherwise. Checks that the path of the directory leaves room for the names of sockets, and
/// that no other user can replace the sockets.
tl::expected<void, MediumError> prepare_directory(const std::string& directory);

/// Returns the boot id of the kernel, for example "6b0c…-…"; an empty text when the kernel does not
/// publish a boot id.
std::string kernel_boot();

/// Returns a text that identifies `directory` on this machine by its inode, for example "2049:131";
/// an empty text when its attributes cannot be read.
std::string inode_of(const std::string& directory);

/// Prepares `directory` by prepare_directory, and returns the result of inode_of for the directory.
tl::expected<std::string, MediumError> directory_identity(const std::string& directory);

/// The lock of a runtime directory. A process holds the lock while it creates or removes sockets in
/// the directory, so that no other process removes a socket between its bind() and its listen().
class DirectoryLock {
 public:
  /// Takes the lock. Waits at most one second if another process holds the lock.
  static tl::expected<DirectoryLock, MediumError> take(const std::string& directory);

 private:
  explicit DirectoryLock(Descriptor held) : held_(std::move(held)) {}
  Descriptor held_;
};

}  // namespace gecos::media::shm
