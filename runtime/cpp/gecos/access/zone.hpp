#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/base/result.hpp"

namespace gecos::access {

/// Decides from the reports of sources whether a person is present in a zone of the laboratory. A
/// person is present when at least one person has checked in or holds a dead-man button, and every
/// door is closed. A button that is silent counts as not held, and a door that is silent counts as
/// open.
///
/// Pure: the caller passes the time, by a clock that also counts while the machine is suspended.
/// The time must not decrease from one call to the next. Not thread-safe.
class Zone {
 public:
  static constexpr Duration report_life = std::chrono::seconds(1);
  static constexpr Duration code_life = std::chrono::seconds(60);
  static constexpr Duration longest_stay = std::chrono::minutes(30);
  static constexpr std::size_t most_wrong_codes = 5;
  static constexpr Duration wrong_codes_within = std::chrono::minutes(1);

  struct Sources {
    std::vector<std::string> buttons;
    std::vector<std::string> doors;
  };
  /// A spell is an uninterrupted time of presence. The zone numbers its spells from
  /// `earlier_spells` + 1, so that no number occurs twice when the server is restarted.
  Zone(std::string name, const Sources& sources, std::uint64_t earlier_spells);

  /// Whether a person is present.
  struct Verdict {
    bool present = false;
    /// The number of the current spell, an uninterrupted time of presence; the number of the last
    /// spell if nobody is present.
    std::uint64_t spell = 0;
    /// A text for people. It says who is present; if nobody is present, it says why, and what to
    /// do.
    std::string why;
    friend bool operator==(const Verdict&, const Verdict&) = default;
  };
  Verdict verdict(TimePoint now);

  // Takes a report of a door or of a button. Returns false when the zone has no source with this
  // name.
  bool door(const std::string& name, bool closed, TimePoint now);
  bool button(const std::string& name, bool held, TimePoint now);

  /// Makes `code` the code for the next check-in and returns true; the caller then shows it in the
  /// laboratory. Returns false, and ignores `code`, while the previous code is still valid. Fails
  /// with a reason after too many wrong codes.
  tl::expected<bool, std::string> show(std::string code, TimePoint now);
  /// Checks `person` in for `stay`, at most longest_stay. A code is valid for one check-in. On
  /// failure, returns the reason.
  tl::expected<void, std::string> check_in(const std::string& code, const std::string& person,
                                           Duration stay, TimePoint now);
  /// Ends the check-in of `person`. Returns false when `person` is not checked in.
  bool check_out(const std::string& person, TimePoint now);

 private:
  struct Code {
    std::string text;
    TimePoint until;
  };

  void judge(TimePoint now);
  bool person_here(TimePoint now) const;
  std::vector<std::string> open_doors(TimePoint now) const;
  std::string who(TimePoint now) const;
  std::string why_absent(TimePoint now) const;
  std::optional<std::string> too_many_wrong(TimePoint now);

  const std::string name_;
  std::map<std::string, TimePoint> buttons_;  ///< the time until which each button counts as held
  std::map<std::string, TimePoint> doors_;    ///< the time until which each door counts as closed
  std::map<std::string, TimePoint> people_;   ///< the time until which each person is checked in
  std::optional<Code> code_;
  std::vector<TimePoint> wrong_;  ///< the times at which wrong codes were given, oldest first
  bool present_ = false;
  std::uint64_t spell_;
};

}  // namespace gecos::access
