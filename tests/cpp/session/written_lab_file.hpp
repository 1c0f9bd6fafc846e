// A lab file of a test's own, which counts at once.
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

#include "../media/scratch_directory.hpp"

namespace probe {

class WrittenLabFile {
 public:
  explicit WrittenLabFile(const std::string& text = "") { write(text); }
  /// Writes the file as if nobody had changed it for a minute since.
  void write(const std::string& text) const {
    std::ofstream(path_) << text;
    std::filesystem::last_write_time(
        path_, std::filesystem::last_write_time(path_) - std::chrono::minutes(1));
  }
  const std::string& path() const { return path_; }

 private:
  const gecos::media::ScratchDirectory directory_;
  const std::string path_ = directory_.path() + "/lab.toml";
};

}  // namespace probe
