#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gecos/broker/processes.hpp"
#include "gecos/broker_types.hpp"

namespace gecos::broker {

/// The file in which a broker lists the objects of this host's processes. Without this file, the
/// next broker would give away the name of a suspended server, because a suspended server cannot
/// register with the next broker. The file has the start time of each process, because a later
/// process may get the same pid.
class KeptNames {
 public:
  explicit KeptNames(std::string path) : path_(std::move(path)) {}

  /// Returns the objects in the file whose processes live, and watches these processes. Leaves out
  /// the objects of the calling process, because this process runs and registers them itself.
  std::vector<Entry> living(Processes& processes) const;
  /// Writes `entries` to the file unless this object wrote the same entries last. `processes` must
  /// watch the process of each entry. Logs a warning when the file cannot be written.
  void keep(const std::vector<Entry>& entries, const Processes& processes);

 private:
  const std::string path_;
  std::optional<std::vector<Entry>> kept_;  ///< what this broker wrote last
  std::string reported_;  ///< the last logged reason for which the file could not be written
};

}  // namespace gecos::broker
