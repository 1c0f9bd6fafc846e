#include "devices/support/real_time.hpp"

#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace devices {
namespace {

constexpr int priority = 80;

std::string meaning(int error) { return std::generic_category().message(error); }

bool has_lock_capability() {
  __user_cap_header_struct header{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  __user_cap_data_struct sets[_LINUX_CAPABILITY_U32S_3] = {};
  return syscall(SYS_capget, &header, &sets) == 0 && (sets[0].effective & 1U << CAP_IPC_LOCK) != 0;
}

/// Under a limit on locked memory, allocations would fail after mlockall once the limit is reached.
/// So the memory is locked only if there is no limit, or if the process may exceed it.
bool may_lock_all() {
  rlimit limit{};
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY) return true;
  return has_lock_capability();
}

}  // namespace

std::optional<std::string> make_real_time() {
  std::string missing;
  const sched_param fifo{.sched_priority = priority};
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo); error != 0) {
    missing = "no real-time priority (SCHED_FIFO: " + meaning(error) + "); permit it with rtprio " +
              std::to_string(priority) + " in /etc/security/limits.conf";
  }
  int error = may_lock_all() ? 0 : EPERM;
  if (error == 0 && mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) error = errno;
  if (error != 0) {
    if (!missing.empty()) missing += "; ";
    missing += "memory that may be paged out (mlockall: " + meaning(error) +
               "); permit the lock with memlock unlimited in /etc/security/limits.conf";
  }
  if (missing.empty()) return std::nullopt;
  return missing;
}

}  // namespace devices
