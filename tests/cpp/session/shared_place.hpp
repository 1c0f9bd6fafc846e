// Where programs of several users of one host meet: a folder that root made for all of them.
#pragma once

#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "../media/scratch_directory.hpp"

namespace probe {

/// Makes this process one of `user`, or throws.
inline void become(const std::string& user) {
  const passwd* const entry = ::getpwnam(user.c_str());
  if (entry == nullptr) throw std::runtime_error("there is no user " + user + " in /etc/passwd");
  if (::setgroups(0, nullptr) != 0 || ::setgid(entry->pw_gid) != 0 ||
      ::setuid(entry->pw_uid) != 0) {
    throw std::runtime_error("cannot become " + user);
  }
}

/// A directory that root made for all users, as /run/gecos, with the lab file of its server.
class SharedPlace {
 public:
  SharedPlace() {
    if (::chmod(directory_.path().c_str(), 01777) != 0) throw std::runtime_error("chmod");
    ::setenv("GECOS_RUNTIME_DIR", directory_.path().c_str(), 1);
    ::setenv("GECOS_LAB_FILE", file().c_str(), 1);
    ::setenv("GECOS_AUDIT_DIR", audit().c_str(), 1);
    write("");
  }
  std::string audit() const { return directory_.path() + "/audit"; }
  std::string file() const { return directory_.path() + "/lab.toml"; }
  void write(const std::string& text) const { std::ofstream(file()) << text; }
  /// Writes the file as if nobody had changed it for a minute since: an edit counts a moment later.
  void edit(const std::string& text) const {
    write(text);
    std::filesystem::last_write_time(
        file(), std::filesystem::last_write_time(file()) - std::chrono::minutes(1));
  }

 private:
  const gecos::media::ScratchDirectory directory_;
};

}  // namespace probe
