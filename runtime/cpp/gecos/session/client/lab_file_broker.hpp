#pragma once

#include <memory>
#include <string>

#include "gecos/access/lab_file.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/file_thread.hpp"
#include "gecos/base/result.hpp"

namespace gecos::session {

/// Reads where the lab file of this program says that the broker is. The file is read on a thread
/// that exists during the reading; while the file system does not answer, the thread waits for it
/// and the caller does not.
class LabFileBroker {
 public:
  /// @param lab_file as LabOptions::lab_file
  explicit LabFileBroker(const std::string& lab_file);
  ~LabFileBroker();

  /// Reads the file. Waits until `deadline` at most, or 100 ms if that is later, also while the
  /// file is being written. A file that does not exist, and that no setting names, says nothing. On
  /// failure returns a sentence with the reason and the remedy.
  tl::expected<access::LabBroker, std::string> read(TimePoint deadline);

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
  std::unique_ptr<FileThread> thread_{};  ///< null while no reading is under way
};

}  // namespace gecos::session
