#pragma once

#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace gecos::benchmarks {

/// Where the benchmark's broker and sockets are, apart from those of this host.
class OwnDirectory {
 public:
  OwnDirectory() {
    std::string path = std::filesystem::temp_directory_path() / "gecos-benchmark-XXXXXX";
    if (::mkdtemp(path.data()) == nullptr) throw std::runtime_error("cannot make " + path);
    path_ = path;
    ::setenv("GECOS_RUNTIME_DIR", path.c_str(), 1);
    ::unsetenv("GECOS_BROKER");
  }
  ~OwnDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  OwnDirectory(const OwnDirectory&) = delete;
  OwnDirectory& operator=(const OwnDirectory&) = delete;

 private:
  std::filesystem::path path_;
};

}  // namespace gecos::benchmarks
