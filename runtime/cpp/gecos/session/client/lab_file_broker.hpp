#pragma once

#include <memory>
#include <string>

#include "gecos/access/lab_file.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/file_thread.hpp"
#include "gecos/base/result.hpp"

namespace gecos::session {

/// Finds out from the lab file of this program where the broker is. The file is read on a thread of
/// its own, so that the caller need not wait for a file system that does not answer.
class LabFileBroker {
 public:
  /// @param lab_file the path of the lab file, as in LabOptions::lab_file
  explicit LabFileBroker(const std::string& lab_file);
  ~LabFileBroker();

  /// Reads the lab file. Waits for the file system, and for a program that is writing the file, at
  /// most until `deadline`, or for 100 ms if `deadline` comes sooner. A missing file counts as an
  /// empty one, unless a setting names the file. On failure returns a sentence with the reason and
  /// the remedy.
  tl::expected<access::LabBroker, std::string> read(TimePoint deadline);

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
  std::unique_ptr<FileThread> thread_{};  ///< null while no reading is under way
};

}  // namespace gecos::session
