#include "gecos/base/checked_result.hpp"

#include <cstdlib>

#include "gecos/base/log.hpp"

namespace gecos {

void used_unchecked(const std::string& why) {
  log_error("program", "a result was used although it holds an error: " + why +
                           ". Check a result (`if (!result) …`) before using it");
  std::abort();
}

}  // namespace gecos
