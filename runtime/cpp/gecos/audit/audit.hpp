#pragma once

#include <memory>
#include <string>

#include "gecos/audit/journal.hpp"
#include "gecos/audit/line.hpp"

namespace gecos::audit {

/// Writes the audit of one server, on a thread of its own, so that no call waits for a disk.
///
/// If lines come faster than the disk takes them, or the disk is full or missing, lines are lost.
/// The log reports this once. As soon as the audit can be written again, it gets a line with the
/// number of lost lines. Thread-safe.
class Audit {
 public:
  /// The largest number of lines that wait to be written. Further lines are lost.
  static constexpr std::size_t most_waiting = 4096;

  explicit Audit(Journal journal);
  ~Audit() { end(); }
  Audit(const Audit&) = delete;
  Audit& operator=(const Audit&) = delete;

  /// Adds a line. Does no input or output.
  void add(Line line);
  /// Wakes the writing thread if lines wait; the first such call starts the thread. The server
  /// calls this function periodically, so that `add` need not wake the thread for each line.
  void flush();
  /// Writes the lines that wait and ends the thread. Waits for the disk at most a second. Lines
  /// that are added later are not written.
  void end();

 private:
  struct Shared;
  void start();

  /// Shared with the writing thread, which may outlive this object.
  const std::shared_ptr<Shared> shared_;
};

}  // namespace gecos::audit
