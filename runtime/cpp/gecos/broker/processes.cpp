#include "gecos/broker/processes.hpp"

#include <signal.h>
#include <sys/epoll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <sstream>
#include <string>

#include "gecos/base/system_error.hpp"

namespace gecos::broker {
namespace {

/// The fields of the file /proc/<pid>/stat that this code reads.
struct Status {
  char state = ' ';  ///< 'Z': ended, not yet waited for by its parent
  std::uint64_t start = 0;
};

Status status_of(std::int32_t pid) {
  std::string line;  // e.g. "4711 (name) S …", with the start as the 22nd word; see proc(5)
  std::getline(std::ifstream("/proc/" + std::to_string(pid) + "/stat"), line);
  const std::size_t name_end = line.rfind(") ");
  if (name_end == std::string::npos) return {};
  std::istringstream words(line.substr(name_end + 2));
  Status status;
  words >> status.state;
  std::string other;
  for (int word = 4; word < 22; ++word) words >> other;
  words >> status.start;
  return status;
}

bool has_ended(std::int32_t pid) {
  if (::kill(pid, 0) != 0) return errno == ESRCH;
  return status_of(pid).state == 'Z';
}

int new_epoll() {
  const int descriptor = ::epoll_create1(EPOLL_CLOEXEC);
  if (descriptor < 0) throw_system_error("epoll_create1", errno);
  return descriptor;
}

}  // namespace

Processes::Processes() : epoll_(new_epoll()) {}

bool Processes::watch(std::int32_t pid) {
  if (pid <= 0) return false;
  if (watched_.contains(pid)) return true;
  Descriptor process(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
  if (!process && (errno == ESRCH || has_ended(pid))) return false;
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = static_cast<std::uint64_t>(pid);
  if (process && ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, process.get(), &event) != 0)
    process.reset();
  watched_.emplace(pid, Watched{std::move(process), status_of(pid).start});
  return true;
}

std::uint64_t Processes::start_of(std::int32_t pid) const {
  const auto found = watched_.find(pid);
  return found == watched_.end() ? 0 : found->second.start;
}

std::vector<std::int32_t> Processes::take_ended() {
  std::vector<std::int32_t> ended;
  std::array<epoll_event, 64> room{};
  for (;;) {
    const int count = ::epoll_wait(epoll_.get(), room.data(), static_cast<int>(room.size()), 0);
    for (int i = 0; i < count; ++i) {
      const auto pid = static_cast<std::int32_t>(room.at(static_cast<std::size_t>(i)).data.u64);
      ended.push_back(pid);
      watched_.erase(pid);  // closes the pidfd, which takes it out of the epoll instance
    }
    if (count < static_cast<int>(room.size())) break;
  }
  std::erase_if(watched_, [&](const auto& one) {
    if (one.second.process || !has_ended(one.first)) return false;
    ended.push_back(one.first);
    return true;
  });
  return ended;
}

std::vector<std::int32_t> Processes::watched() const {
  std::vector<std::int32_t> pids;
  for (const auto& [pid, process] : watched_) pids.push_back(pid);
  return pids;
}

}  // namespace gecos::broker
