#include "gecos/base/user_and_host.hpp"

#include <pwd.h>
#include <unistd.h>

#include <array>

namespace gecos {

std::string user_name(std::uint32_t uid) {
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> text;
  if (::getpwuid_r(uid, &entry, text.data(), text.size(), &found) != 0 || found == nullptr) {
    return "uid " + std::to_string(uid);
  }
  return entry.pw_name;
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "?";
}

}  // namespace gecos
