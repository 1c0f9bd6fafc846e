#include "gecos/session/process/pause_watch.hpp"

#include <cstdio>

namespace gecos::session {

std::string stood_still_for(Duration pause) {
  char text[48];
  std::snprintf(text, sizeof text, "stood still for %.1f s",
                std::chrono::duration<double>(pause).count());
  return text;
}

}  // namespace gecos::session
