#include "gecos/base/pid_namespace.hpp"

#include <sys/stat.h>

namespace gecos {

std::uint64_t pid_namespace() {
  struct stat found {};
  return ::stat("/proc/self/ns/pid", &found) == 0 ? found.st_ino : 0;
}

}  // namespace gecos
