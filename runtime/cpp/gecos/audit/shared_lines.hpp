#pragma once

#include <memory>
#include <string>

#include "gecos/audit/audit.hpp"
#include "gecos/audit/repeats.hpp"

namespace gecos::audit {

/// Writes the events that users who are not admitted can cause without end, for example refused
/// connections. Events of one kind share lines: the first event has a line of its own, and later
/// lines count the further events, about one line a minute (Repeats::Window::Growing).
///
/// When there are more than `most_kinds` kinds at the same time, the events of all further kinds
/// share lines about "several users", until none of them has occurred for a minute. So a program
/// with many users, or with invented names, cannot push the older lines out of the audit quickly.
///
/// The caller passes the time. Only one thread at a time may use this class.
class SharedLines {
 public:
  /// The maximum number of kinds of events that are counted at the same time.
  static constexpr std::size_t most_kinds = 256;

  /// `object`: the object that the lines about several users name; may be empty. `audit` may be
  /// null if `add` is never called.
  SharedLines(std::string object, std::shared_ptr<Audit> audit)
      : object_(std::move(object)), audit_(std::move(audit)) {}

  /// Writes `line`, or counts its event. `further` is the line that counts the following events of
  /// the same kind, so it must have only members that all these events share. Two events are of one
  /// kind if their lines `further` have the same event, user, host, object and reason; digits in
  /// the reason are ignored, because a reason may say since when something has lasted.
  ///
  /// Replaces `request.session` in the lines by a number of the kind, and returns this number. A
  /// line that counts requests names only the first and the last request; by the number of the
  /// kind, a reader excludes the requests of other kinds in between.
  std::uint64_t add(Line line, Line further);
  /// Writes the lines of the kinds of events whose time window of counting is over.
  void on_tick(std::int64_t now);
  /// Writes the lines of all events that were counted.
  void end(std::int64_t now);

 private:
  const std::string object_;
  const std::shared_ptr<Audit> audit_;
  /// Counts `most_kinds` kinds of events, and some more for the lines about several users: each
  /// event name needs one such line.
  Repeats repeats_{most_kinds + 16};
};

}  // namespace gecos::audit
