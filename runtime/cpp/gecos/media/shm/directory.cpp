#include "gecos/media/shm/directory.hpp"

#include <fcntl.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

#include "gecos/base/system_error.hpp"

namespace gecos::media::shm {
namespace {

constexpr const char* administrators_directory = "/run/gecos";
/// The maximum length of the directory's path. The path of a socket may have at most 107
/// characters, and the file name of a socket may take 57 of them.
constexpr std::size_t longest_directory = 50;

tl::unexpected<MediumError> error(const std::string& text) {
  return tl::unexpected(MediumError{"shm: " + text});
}

/// Returns whether a directory is owned by root and sticky, like /tmp. In such a directory, every
/// user can make files and can remove only the user's own files.
bool sticky_of_root(const struct stat& found) {
  return S_ISDIR(found.st_mode) && found.st_uid == 0 && (found.st_mode & S_ISVTX) != 0;
}

/// Reads the attributes of `directory` like stat(), but does not follow a symbolic link that
/// another user may have made.
bool look_at(const std::string& directory, struct stat& found) {
  struct stat parent {};
  const std::string above = std::filesystem::path(directory).parent_path().string();
  const bool others_make_links =
      ::stat(above.c_str(), &parent) == 0 && (parent.st_mode & (S_IWGRP | S_IWOTH)) != 0;
  return (others_make_links ? ::lstat : ::stat)(directory.c_str(), &found) == 0;
}

bool shared_between_users(const std::string& directory) {
  struct stat found {};
  return look_at(directory, found) && sticky_of_root(found);
}

std::string folder_of(std::uint32_t uid, const std::string& in) {
  return in + "/gecos-" + std::to_string(uid);
}

std::string parent_of(const std::string& directory) {
  return std::filesystem::path(directory).parent_path().string();
}

constexpr const char* name_of_gecos = "gecos";

/// Returns the number of the user `gecos`; no value when there is no such user.
std::optional<std::uint32_t> user_gecos() {
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> text;
  if (::getpwnam_r(name_of_gecos, &entry, text.data(), text.size(), &found) != 0 ||
      found == nullptr) {
    return std::nullopt;
  }
  return entry.pw_uid;
}

/// Returns whether `directory` is a folder of the user `uid` that all users can reach, in a
/// directory that an administrator made for all users. /tmp does not count, because every system
/// has /tmp.
bool open_to_all(const std::string& directory, std::uint32_t uid) {
  const std::string parent = parent_of(directory);
  return parent != "/tmp" && directory == folder_of(uid, parent) && shared_between_users(parent);
}

}  // namespace

std::string default_runtime_directory() {
  if (const char* named = std::getenv("GECOS_RUNTIME_DIR"); named != nullptr && *named != '\0') {
    std::string directory = named;
    while (directory.size() > 1 && directory.back() == '/') directory.pop_back();
    return shared_between_users(directory) ? folder_of(::geteuid(), directory) : directory;
  }
  const bool administered = shared_between_users(administrators_directory) &&
                            ::access(administrators_directory, W_OK) == 0;
  return folder_of(::geteuid(), administered ? administrators_directory : "/tmp");
}

bool serves_the_host(std::uint32_t uid) { return uid == 0 || uid == user_gecos(); }
bool serves_the_host(std::string_view user) { return user == "root" || user == name_of_gecos; }

bool open_to_all_users(const std::string& directory) {
  const std::uint32_t user = ::geteuid();
  return open_to_all(directory, user) && serves_the_host(user);
}

std::vector<std::string> directories_of_the_host(const std::string& directory) {
  const std::string parent = parent_of(directory);
  if (!open_to_all(directory, ::geteuid())) return {};
  std::vector<std::string> found;
  for (const auto user : {user_gecos(), std::optional<std::uint32_t>(0)}) {
    if (!user || user == ::geteuid()) continue;
    std::string of_user = folder_of(*user, parent);
    struct stat seen {};
    if (look_at(of_user, seen) && S_ISDIR(seen.st_mode) && seen.st_uid == *user) {
      found.push_back(std::move(of_user));
    }
  }
  return found;
}

tl::expected<void, MediumError> prepare_directory(const std::string& directory) {
  if (directory.size() > longest_directory) {
    return error("the path " + directory + " has " + std::to_string(directory.size()) +
                 " characters, but sockets need a directory whose path has at most " +
                 std::to_string(longest_directory) +
                 "; name a shorter directory in GECOS_RUNTIME_DIR");
  }
  const bool for_all = open_to_all_users(directory);
  if (::mkdir(directory.c_str(), for_all ? 0711 : 0700) != 0 && errno != EEXIST) {
    return error("cannot make " + directory + ": " + system_text(errno) +
                 "; name another directory in GECOS_RUNTIME_DIR");
  }
  struct stat found {};
  if (!look_at(directory, found)) {
    return error("cannot read the attributes of " + directory + ": " + system_text(errno));
  }
  if (!S_ISDIR(found.st_mode)) {
    return error(directory +
                 " is not a directory; remove it or name another directory in "
                 "GECOS_RUNTIME_DIR");
  }
  if (sticky_of_root(found)) return {};
  if (found.st_uid != ::geteuid()) {
    return error(directory + " belongs to uid " + std::to_string(found.st_uid) +
                 ", who could listen in; name a directory of your own in GECOS_RUNTIME_DIR");
  }
  if ((found.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return error("other users may write to " + directory +
                 " and could listen in; run:  chmod go-w " + directory);
  }
  // The folder may have been made without access for other users, by an earlier version of this
  // program or because of the umask.
  if (for_all && (found.st_mode & 0777) != 0711 && ::chmod(directory.c_str(), 0711) != 0) {
    return error("cannot open " + directory + " to the users of this host: " + system_text(errno));
  }
  return {};
}

std::string kernel_boot() {
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  return boot;
}

std::string inode_of(const std::string& directory) {
  struct stat found {};
  if (::stat(directory.c_str(), &found) != 0) return "";
  return std::to_string(found.st_dev) + ":" + std::to_string(found.st_ino);
}

tl::expected<std::string, MediumError> directory_identity(const std::string& directory) {
  if (auto prepared = prepare_directory(directory); !prepared) {
    return tl::unexpected(std::move(prepared.error()));
  }
  std::string inode = inode_of(directory);
  if (!inode.empty()) return inode;
  return error("cannot read the attributes of " + directory + ": " + system_text(errno));
}

tl::expected<DirectoryLock, MediumError> DirectoryLock::take(const std::string& directory) {
  Descriptor opened(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened) return error("cannot open " + directory + ": " + system_text(errno));
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  while (::flock(opened.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) {
      return error("cannot lock " + directory + ": " + system_text(errno));
    }
    if (std::chrono::steady_clock::now() >= patience) {
      return error("another program has kept " + directory + " locked for a second; `fuser -v " +
                   directory + "` shows which program");
    }
    const timespec a_little{0, 1'000'000};
    ::nanosleep(&a_little, nullptr);
  }
  return DirectoryLock(std::move(opened));
}

}  // namespace gecos::media::shm
