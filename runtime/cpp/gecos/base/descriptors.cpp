#include "gecos/base/descriptors.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <vector>

namespace gecos {

bool descriptors_left(std::size_t count) {
  std::vector<int> taken;
  taken.reserve(count);
  int problem = 0;
  while (taken.size() < count && problem == 0) {
    const int one = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (one < 0) {
      problem = errno;
    } else {
      taken.push_back(one);
    }
  }
  for (const int one : taken) ::close(one);
  errno = problem;
  return problem == 0;
}

}  // namespace gecos
