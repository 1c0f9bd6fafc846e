#pragma once

#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace gecos::media {

/// A directory that goes when the test goes.
class ScratchDirectory {
 public:
  ScratchDirectory() {
    std::string pattern = "/tmp/gecos-test-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp");
    path_ = pattern;
  }
  ~ScratchDirectory() {
    if (owner_ == ::getpid()) std::filesystem::remove_all(path_);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  const pid_t owner_ = ::getpid();
};

}  // namespace gecos::media
