#pragma once

#include <memory>
#include <optional>
#include <string>

#include "gecos/access/lab_file.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/file_thread.hpp"

namespace gecos::session {

/// Reads the lab file of one server again and again, on a separate thread, so that a file system
/// that does not answer delays nothing else. If the file has an error, the error is logged once and
/// the previous lists stay in force. They also stay in force while a program seems to be writing
/// the file: the file was changed within the last 100 ms or during the reading, or was emptied
/// within the last second. Thread-safe.
class LabFileReader {
 public:
  /// @param lab_file the path of the lab file, as in LabOptions::lab_file
  explicit LabFileReader(const std::string& lab_file);

  /// The results of all readings so far.
  struct Found {
    /// The lists of the last text without an error. They are empty before there was such a text,
    /// and never null.
    std::shared_ptr<const access::LabAccess> lists;
    bool known = false;                           ///< whether there was a text without an error
    std::optional<access::LabFileError> error{};  ///< the error in the last text
    /// True before the first reading, and if the file was being written at the last reading.
    bool being_written = true;
  };
  Found found() const;
  /// Returns `found().lists` without copying the other members.
  std::shared_ptr<const access::LabAccess> lists() const;
  const std::string& path() const { return path_; }

  /// Requests that the thread reads the file again soon.
  void ask() { thread_.ask(); }
  /// Requests that the thread reads the file again, and waits until it has read the file. Returns
  /// false if the file system has not answered for `patience`.
  bool read(Duration patience) { return thread_.await(thread_.ask(), patience); }

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
  const std::string path_;
  FileThread thread_;
};

}  // namespace gecos::session
