#pragma once

#include <memory>
#include <string>

#include "gecos/access/lab_file.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/result.hpp"

namespace gecos::session {

/// What the lab file states about the media, or a sentence that says why the file cannot be used.
using StatedMedia = tl::expected<access::LabMedia, std::string>;

/// The settings in the lab file of this program that clients need: where the broker is, and which
/// media are real-time. Each function reads the file anew, on a thread of its own, so that the
/// caller need not wait for a file system that does not answer. Thread-safe.
///
/// The functions wait for the file system, and for a program that is writing the file, at most
/// until `deadline`, or for 100 ms if `deadline` comes sooner. A missing file counts as an empty
/// one, unless a setting names the file. On failure they return a sentence with the reason and the
/// remedy.
class LabFileSettings {
 public:
  /// @param lab_file the path of the lab file, as in LabOptions::lab_file
  explicit LabFileSettings(const std::string& lab_file);
  ~LabFileSettings();

  tl::expected<access::LabBroker, std::string> broker(TimePoint deadline);
  StatedMedia media(TimePoint deadline);

 private:
  struct Reading;
  /// Returns the text of the file, or why there is none.
  tl::expected<std::string, std::string> text(TimePoint deadline);
  /// Returns the reading that is under way, or begins one. Throws std::system_error when no thread
  /// can be started.
  std::shared_ptr<Reading> present_reading();
  /// Makes the next call of `present_reading` begin another reading than `done`.
  void end(const std::shared_ptr<Reading>& done);

  const std::string path_;
  const bool must_exist_;  ///< a setting names the file
  Mutex mutex_;
  /// Null while no reading is under way. It stays while the file system does not answer, so that
  /// further calls start no further threads.
  std::shared_ptr<Reading> reading_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
