#pragma once

#include <memory>
#include <optional>
#include <string>

#include "gecos/access/lab_file.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/file_thread.hpp"

namespace gecos::session {

/// Reads the lab file of one server, again and again, on a thread of its own: a file system that
/// does not answer delays nothing else. An edit with an error is logged once and changes nothing;
/// nor does a file that is being written: one that was changed within the last 100 ms or while it
/// was read, or emptied within the last second. Thread-safe.
class LabFileReader {
 public:
  /// @param lab_file as LabOptions::lab_file
  explicit LabFileReader(const std::string& lab_file);

  /// What the readings have found.
  struct Found {
    /// The lists of the last text without an error. Never null: empty before there is one.
    std::shared_ptr<const access::LabAccess> lists;
    bool known = false;                           ///< whether there was a text without an error
    std::optional<access::LabFileError> error{};  ///< of the last text
    bool being_written = true;                    ///< the last reading found no text that counts
  };
  Found found() const;
  /// Returns `found().lists`, without copying the rest.
  std::shared_ptr<const access::LabAccess> lists() const;
  const std::string& path() const { return path_; }

  /// Makes the thread read the file again, soon.
  void ask() { thread_.ask(); }
  /// Makes the thread read the file again, and waits until it has. Returns false if the file system
  /// has not answered for `patience`.
  bool read(Duration patience) { return thread_.await(thread_.ask(), patience); }

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
  const std::string path_;
  FileThread thread_;
};

}  // namespace gecos::session
