#include "gecos/base/process_barrier.hpp"

#include <linux/membarrier.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace gecos {
namespace {

bool membarrier(int command) noexcept {
  return ::syscall(__NR_membarrier, command, 0, 0) == 0;  // glibc has no function for it
}

}  // namespace

bool join_barriers() noexcept { return membarrier(MEMBARRIER_CMD_REGISTER_GLOBAL_EXPEDITED); }

bool barrier_for_all() noexcept { return membarrier(MEMBARRIER_CMD_GLOBAL_EXPEDITED); }

}  // namespace gecos
