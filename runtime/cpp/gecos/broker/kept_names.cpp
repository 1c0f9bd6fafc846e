#include "gecos/broker/kept_names.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/binding.hpp"
#include "gecos/wire/contents.hpp"

namespace gecos::broker {
namespace {

KeptList read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return {};  // the first broker in this directory
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  auto list = wire::from_bytes<KeptList>(std::as_bytes(std::span(text)));
  if (list) return *std::move(list);
  log_warning("broker",
              path + " is not readable (" + list.error().message() +
                  "): this broker does not know which suspended servers of this host have names");
  return {};
}

/// Replaces the contents of the file `path`. Returns 0, or the errno of the failure. Even if this
/// process ends during the call, the file has either its old or its new contents.
int replace(const std::string& path, ByteView contents) {
  const std::string next = path + ".new";
  const Descriptor file(
      ::open(next.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!file) return errno;
  while (!contents.empty()) {
    const ssize_t written = ::write(file.get(), contents.data(), contents.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    contents = contents.subspan(static_cast<std::size_t>(written));
  }
  return ::rename(next.c_str(), path.c_str()) == 0 ? 0 : errno;
}

}  // namespace

std::vector<Entry> KeptNames::living(Processes& processes) const {
  std::vector<Entry> entries;
  KeptList before = read(path_);
  for (KeptObject& one : before.objects) {
    const std::int32_t pid = one.entry.pid;
    if (pid == ::getpid() || !session::sees_process(one.entry)) continue;
    if (processes.watch(pid) && processes.start_of(pid) == one.process_start)
      entries.push_back(std::move(one.entry));
  }
  return entries;
}

void KeptNames::keep(const std::vector<Entry>& entries, const Processes& processes) {
  if (kept_ == entries) return;
  KeptList list;
  for (const Entry& entry : entries) list.objects.push_back({entry, processes.start_of(entry.pid)});
  const int failed = replace(path_, wire::to_bytes(list));
  if (failed == 0) kept_ = entries;
  std::string why = failed == 0 ? std::string() : system_text(failed);
  if (!why.empty() && why != reported_) {
    log_warning("broker", "cannot write " + path_ + ": " + why +
                              "; when the broker is started again, the names of suspended servers "
                              "are free for others");
  }
  reported_ = std::move(why);
}

}  // namespace gecos::broker
