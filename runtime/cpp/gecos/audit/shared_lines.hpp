#pragma once

#include <memory>
#include <string>

#include "gecos/audit/audit.hpp"
#include "gecos/audit/repeats.hpp"

namespace gecos::audit {

/// Writes the events that users who are not admitted can cause without end, for example refused
/// connections. Events of one kind share lines: the first event has a line of its own, and the
/// further lines count the others, about one line a minute (Repeats::Window::Growing).
///
/// When there are more than `most_kinds` kinds at the same time, all further kinds share lines
/// about "several users", until there was no such event for a minute. So a program with many
/// users, or with invented names, cannot push the older lines out of the audit quickly.
///
/// The caller passes the time. Only one thread at a time may use this class.
class SharedLines {
 public:
  /// Kinds of events that are counted at the same time.
  static constexpr std::size_t most_kinds = 256;

  /// `object`: what the lines about several users say of their object; may be empty. `audit` may be
  /// null, if `add` is not called.
  SharedLines(std::string object, std::shared_ptr<Audit> audit)
      : object_(std::move(object)), audit_(std::move(audit)) {}

  /// Writes `line`, or counts its event. `further` is the line that counts several such events: it
  /// must have only what they share. Two events are of one kind if `further` has the same event,
  /// user, host, object and reason; digits of the reason do not matter, because a reason may say
  /// since when something has lasted.
  ///
  /// Replaces `request.session` in the lines by a number of the kind, and returns that number: a
  /// line that counts requests names the first and the last one, and the numbers of other kinds in
  /// between must not be taken for some of them.
  std::uint64_t add(Line line, Line further);
  /// Writes the lines of the events that were counted and whose window is over.
  void on_tick(std::int64_t now);
  /// Writes the lines of all events that were counted.
  void end(std::int64_t now);

 private:
  const std::string object_;
  const std::shared_ptr<Audit> audit_;
  /// There is room for the few kinds about several users, too: one for each name of an event.
  Repeats repeats_{most_kinds + 16};
};

}  // namespace gecos::audit
