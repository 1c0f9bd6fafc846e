#include "gecos/base/system_error.hpp"

#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace gecos {
namespace {

std::string advice(int error) {
  if (error == EMFILE) {
    return "see `ulimit -n` and `ls -l /proc/" + std::to_string(::getpid()) + "/fd`";
  }
  if (error == ENFILE) return "see `cat /proc/sys/fs/file-nr`";
  return {};
}

}  // namespace

std::string system_text(int error) {
  const std::string what_to_do = advice(error);
  const std::string text = std::generic_category().message(error);
  return what_to_do.empty() ? text : text + " (" + what_to_do + ")";
}

void throw_system_error(std::string_view what, int error) {
  const std::string what_to_do = advice(error);
  throw std::system_error(error, std::generic_category(),
                          std::string(what) + (what_to_do.empty() ? "" : " (" + what_to_do + ")"));
}

}  // namespace gecos
