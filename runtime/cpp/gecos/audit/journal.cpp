#include "gecos/audit/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <utility>

#include "gecos/base/system_error.hpp"

namespace gecos::audit {
namespace {

/// Creates a folder and its missing parents, which only this user may access. Does not change
/// folders that exist.
void make_folders(const std::string& path) {
  for (std::size_t end = 1; end != std::string::npos;) {
    end = path.find('/', end + 1);
    ::mkdir(path.substr(0, end).c_str(), 0700);  // when this fails, opening the file tells why
  }
}

/// Returns why the audit must not be written to the open file `file`; an empty text if the file may
/// be written.
std::string distrust(int file) {
  struct stat found {};
  if (::fstat(file, &found) != 0) return system_text(errno);
  if (!S_ISREG(found.st_mode)) return "this is not a regular file";
  if (found.st_uid != ::geteuid()) return "the file belongs to another user";
  return "";
}

}  // namespace

Journal::Journal(std::string folder, Limits limits) : folder_(std::move(folder)), limits_(limits) {}

std::string Journal::path(unsigned age) const {
  return folder_ + (age == 0 ? "/audit.jsonl" : "/audit." + std::to_string(age) + ".jsonl");
}

tl::expected<void, std::string> Journal::append(std::string_view lines) {
  if (!current()) {
    if (auto opened = open(); !opened) return opened;
  }
  if (torn_) {
    if (auto ended = write("\n"); !ended) return ended;
  }
  auto written = write(lines);
  torn_ = !written;
  if (written) rotate();
  return written;
}

tl::expected<void, std::string> Journal::open() {
  constexpr int flags = O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  file_ = Descriptor(::open(path(0).c_str(), flags, 0600));
  if (!file_ && errno == ENOENT) {
    make_folders(folder_);
    file_ = Descriptor(::open(path(0).c_str(), flags, 0600));
  }
  std::string why = file_ ? distrust(file_.get()) : system_text(errno);
  if (why.empty()) return {};
  file_.reset();
  return tl::unexpected(path(0) + ": " + why);
}

tl::expected<void, std::string> Journal::write(std::string_view bytes) {
  // Writes all lines by one write(), so that lines of two processes do not mix.
  const ssize_t count = ::write(file_.get(), bytes.data(), bytes.size());
  if (count == static_cast<ssize_t>(bytes.size())) return {};
  return tl::unexpected(path(0) + ": " + system_text(count < 0 ? errno : ENOSPC));
}

/// Returns whether `file_`, which is open, is still the file that has the path path(0). Another
/// process may have renamed the file and created a new one at this path.
bool Journal::current() const {
  struct stat ours {};
  struct stat named {};
  return file_ && ::fstat(file_.get(), &ours) == 0 && ::stat(path(0).c_str(), &named) == 0 &&
         ours.st_ino == named.st_ino && ours.st_dev == named.st_dev;
}

void Journal::rotate() {
  struct stat ours {};
  if (::fstat(file_.get(), &ours) != 0) return;
  if (static_cast<std::size_t>(ours.st_size) < limits_.bytes) return;
  const Descriptor lock(
      ::open((folder_ + "/audit.lock").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  // Does not wait for the lock, because the process that holds the lock may be suspended.
  if (!lock || ::flock(lock.get(), LOCK_EX | LOCK_NB) != 0 || !current()) return;
  for (unsigned age = limits_.files - 1; age > 0; --age) {
    ::rename(path(age - 1).c_str(), path(age).c_str());
  }
  file_.reset();
}

}  // namespace gecos::audit
