#include "gecos/session/process/lab_file_text.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>

#include "gecos/base/clock.hpp"
#include "gecos/base/descriptor.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/base/user_and_host.hpp"

namespace gecos::session {
namespace {

using access::EditedLabFile;
using access::LabFileError;

constexpr const char* of_this_host = "/etc/gecos/lab.toml";
// The TOML parser recurses for each part of a dotted key: a key with 200,000 parts would overflow
// the stack and end the process. Therefore no larger file is read.
constexpr std::size_t largest_file = 1 << 16;
/// The lab file is read only if it has not changed for this time.
constexpr Duration settled_file = std::chrono::milliseconds(100);
constexpr Duration settled_empty_file = std::chrono::seconds(1);

/// Returns why no program may use a file with these attributes; an empty text when programs may use
/// the file.
std::string distrust(const struct stat& file, const std::string& path) {
  if (!S_ISREG(file.st_mode)) return "this is not a regular file";
  if (file.st_uid != 0 && file.st_uid != ::geteuid()) {
    return "the file belongs to " + user_name(file.st_uid) +
           ", who could admit anyone and name any broker; run: chown " + user_name(::geteuid()) +
           " " + path;
  }
  if ((file.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return "other users may write to the file and could admit anyone and name any broker; run: "
           "chmod go-w " +
           path;
  }
  if (static_cast<std::size_t>(file.st_size) > largest_file)
    return "the file is larger than 64 KiB";
  return "";
}

/// Returns whether another program seems to be writing the file. Most editors empty a file before
/// they write it, and a half-written file may be valid although its last rules are missing.
bool is_being_written(const struct stat& file) {
  using std::chrono::system_clock;
  const auto changed = system_clock::time_point(std::chrono::duration_cast<system_clock::duration>(
      std::chrono::seconds(file.st_mtim.tv_sec) + std::chrono::nanoseconds(file.st_mtim.tv_nsec)));
  const auto age = system_clock::now() - changed;
  return std::chrono::abs(age) < (file.st_size == 0 ? settled_empty_file : settled_file);
}

/// Returns whether a program changed the file between two readings of its attributes. Also compares
/// the times at which the attributes changed (ctime), because a program can set the modification
/// time of a file, but not its ctime.
bool was_changed(const struct stat& before, const struct stat& after) {
  const auto equal = [](const timespec& one, const timespec& other) {
    return one.tv_sec == other.tv_sec && one.tv_nsec == other.tv_nsec;
  };
  return before.st_size != after.st_size || !equal(before.st_mtim, after.st_mtim) ||
         !equal(before.st_ctim, after.st_ctim);
}

}  // namespace

LabFilePath lab_file_path(const std::string& option) {
  const char* const variable = std::getenv("GECOS_LAB_FILE");
  const std::string named = !option.empty() ? option : variable != nullptr ? variable : "";
  if (named.empty()) return {of_this_host, false};
  std::error_code unknown_folder;
  const auto absolute = std::filesystem::absolute(named, unknown_folder);
  return {unknown_folder ? named : absolute.string(), true};
}

std::optional<EditedLabFile::Text> lab_file_text(const std::string& path, bool& must_exist) {
  const auto failed = [&](const std::string& why) {
    return tl::unexpected(LabFileError{path, 0, "", why});
  };
  // O_NONBLOCK: opening a named pipe must not block the program.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file && errno == ENOENT && !must_exist) return std::string();
  const bool no_descriptor = !file && (errno == EMFILE || errno == ENFILE);
  // If no descriptor is left, it is not known whether the file exists.
  if (!no_descriptor) must_exist = true;
  struct stat before {};
  if (!file || ::fstat(file.get(), &before) != 0) {
    return failed("the file cannot be read: " + system_text(errno));
  }
  if (const std::string why = distrust(before, path); !why.empty()) return failed(why);
  if (is_being_written(before)) return std::nullopt;
  std::string text;
  std::array<char, 4096> part;
  ssize_t count = 0;
  while (text.size() <= largest_file &&
         (count = ::read(file.get(), part.data(), part.size())) > 0) {
    text.append(part.data(), static_cast<std::size_t>(count));
  }
  struct stat after {};
  if (count < 0 || ::fstat(file.get(), &after) != 0) {
    return failed("the file cannot be read: " + system_text(errno));
  }
  const bool all_read = text.size() == static_cast<std::size_t>(after.st_size);
  if (!all_read || was_changed(before, after)) return std::nullopt;
  return text;
}

}  // namespace gecos::session
