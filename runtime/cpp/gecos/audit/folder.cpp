#include "gecos/audit/folder.hpp"

#include <pwd.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

namespace gecos::audit {
namespace {

std::string set(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::string home() {
  if (const std::string named = set("HOME"); !named.empty()) return named;
  std::array<char, 4096> names;
  struct passwd entry {};
  struct passwd* found = nullptr;
  ::getpwuid_r(::geteuid(), &entry, names.data(), names.size(), &found);
  return found == nullptr ? "" : found->pw_dir;
}

}  // namespace

std::string default_folder() {
  if (const std::string chosen = set("GECOS_AUDIT_DIR"); !chosen.empty()) return chosen;
  if (const std::string state = set("XDG_STATE_HOME"); !state.empty()) {
    return state + "/gecos/audit";
  }
  return home() + "/.local/state/gecos/audit";
}

}  // namespace gecos::audit
