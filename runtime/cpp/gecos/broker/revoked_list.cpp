#include "gecos/broker/revoked_list.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <utility>

#include "gecos/base/descriptor.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/crypto/key_directory.hpp"

namespace gecos::broker {
namespace {

constexpr Duration answer_within = std::chrono::milliseconds(250);

/// Returns the text of the file; an empty text if there is no file.
tl::expected<std::string, std::string> text_of(const std::string& path) {
  const auto failed = [&](const std::string& why) { return tl::unexpected(path + ": " + why); };
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW));
  if (!file && errno == ENOENT) return std::string();
  struct stat about {};
  if (!file || ::fstat(file.get(), &about) != 0) {
    return failed("the file cannot be read: " + system_text(errno));
  }
  if (!S_ISREG(about.st_mode)) return failed("this is not a regular file");
  if (about.st_uid != ::geteuid() || (about.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return failed("other users may write to the file; become its owner, and run: chmod 600 " +
                  path);
  }
  std::string text;
  std::array<char, 4096> part;
  ssize_t count = 0;
  while (text.size() <= access::largest_revocation_file &&
         (count = ::read(file.get(), part.data(), part.size())) > 0) {
    text.append(part.data(), static_cast<std::size_t>(count));
  }
  if (count < 0) return failed("the file cannot be read: " + system_text(errno));
  if (text.size() > access::largest_revocation_file) return failed("the file is larger than 1 MiB");
  return text;
}

RevokedList::Reading read_file(const std::string& path) {
  const auto text = text_of(path);
  if (!text) return tl::unexpected(text.error());
  auto list = access::read_revocations(*text);
  if (!list) return tl::unexpected(path + ": " + list.error());
  return std::make_shared<const RevokedList::Found>(
      RevokedList::Found{access::number_of_revocations(*text), *std::move(list)});
}

}  // namespace

/// The data that the thread uses. They outlive the RevokedList if the file system does not answer.
struct RevokedList::Shared {
  explicit Shared(std::string file) : path(std::move(file)) {}
  void work() {
    Reading now = read_file(path);
    const MutexLock lock(mutex);
    last.swap(now);
  }

  const std::string path;
  Mutex mutex;
  Reading last GECOS_GUARDED_BY(mutex){std::make_shared<const Found>()};
};

RevokedList::RevokedList(const std::string& path)
    : shared_(std::make_shared<Shared>(
          path.empty() ? crypto::KeyDirectory::default_path() + "/revoked" : path)),
      thread_("gecos-revoked", [shared = shared_] { shared->work(); }) {}

RevokedList::Reading RevokedList::read() {
  if (!thread_.await(thread_.ask(), answer_within)) {
    return tl::unexpected(shared_->path + ": the file system does not answer");
  }
  const MutexLock lock(shared_->mutex);
  return shared_->last;
}

}  // namespace gecos::broker
