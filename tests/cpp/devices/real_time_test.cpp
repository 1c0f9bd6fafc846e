#include "devices/support/real_time.hpp"

#include <gtest/gtest.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <thread>

namespace devices {
namespace {

/// Takes all capabilities from the calling thread.
void drop_capabilities() {
  __user_cap_header_struct header{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  const __user_cap_data_struct none[_LINUX_CAPABILITY_U32S_3] = {};
  ASSERT_EQ(syscall(SYS_capset, &header, &none), 0);
}

/// Permits this process no more than `most` of a resource, until the end of the scope.
class Limit {
 public:
  Limit(__rlimit_resource_t resource, rlim_t most) : resource_(resource) {
    EXPECT_EQ(getrlimit(resource_, &before_), 0);
    const rlimit lower{.rlim_cur = most, .rlim_max = before_.rlim_max};
    EXPECT_EQ(setrlimit(resource_, &lower), 0);
  }
  ~Limit() { EXPECT_EQ(setrlimit(resource_, &before_), 0); }
  Limit(const Limit&) = delete;
  Limit& operator=(const Limit&) = delete;

 private:
  const __rlimit_resource_t resource_;
  rlimit before_{};
};

TEST(RealTime, WhatIsNotPermittedIsSaidWithTheWayToPermitIt) {
  const Limit priority(RLIMIT_RTPRIO, 0);
  const Limit memory(RLIMIT_MEMLOCK, 65536);
  std::thread([] {
    drop_capabilities();
    const auto missing = make_real_time();
    ASSERT_TRUE(missing);
    EXPECT_EQ(*missing,
              "no real-time priority (SCHED_FIFO: Operation not permitted); permit it with rtprio "
              "80 in /etc/security/limits.conf; memory that may be paged out (mlockall: Operation "
              "not permitted); permit the lock with memlock unlimited in "
              "/etc/security/limits.conf");
    EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
  }).join();
}

TEST(RealTime, ThePriorityIsThatOfTheCallingThreadAlone) {
  std::thread([] {
    const sched_param lowest{.sched_priority = 1};
    const bool permitted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &lowest) == 0;
    const auto missing = make_real_time();
    const bool told = missing && missing->find("SCHED_FIFO") != std::string::npos;
    EXPECT_EQ(permitted, !told) << missing.value_or("nothing is missing");
    EXPECT_EQ(sched_getscheduler(0), permitted ? SCHED_FIFO : SCHED_OTHER);
  }).join();
  EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
  EXPECT_EQ(munlockall(), 0);
}

}  // namespace
}  // namespace devices
