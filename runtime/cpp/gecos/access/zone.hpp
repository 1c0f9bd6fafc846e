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
/// door is closed. What is not known counts as absent: a silent button is not held, and a silent
/// door is open.
///
/// Pure: the caller passes the time, by a clock that also counts while the machine is suspended. No
/// function may be called with an earlier time than the one before. Not thread-safe.
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
  /// `earlier_spells`: the number of the last spell of an earlier life of this zone, or a larger
  /// one.
  Zone(std::string name, const Sources& sources, std::uint64_t earlier_spells);

  /// Whether a person is present.
  struct Verdict {
    bool present = false;
    std::uint64_t spell = 0;  ///< number of the present time of presence, or of the last one
    std::string why;  ///< a text for people: who is present; or why nobody is, and what to do
    friend bool operator==(const Verdict&, const Verdict&) = default;
  };
  Verdict verdict(TimePoint now);

  // Reports of sources. They return false when the zone has no such source.
  bool door(const std::string& name, bool closed, TimePoint now);
  bool button(const std::string& name, bool held, TimePoint now);

  /// Offers a new code, which the caller shows in the laboratory if it is accepted. Returns false
  /// while the last code that was accepted is still good. Fails and says why while too many wrong
  /// codes were given.
  tl::expected<bool, std::string> show(std::string code, TimePoint now);
  /// Checks `person` in for `stay`, at most longest_stay. The code is good for one check-in. Fails
  /// and says why.
  tl::expected<void, std::string> check_in(const std::string& code, const std::string& person,
                                           Duration stay, TimePoint now);
  /// Returns false when `person` is not checked in.
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
  std::map<std::string, TimePoint> buttons_;  ///< until when each counts as held
  std::map<std::string, TimePoint> doors_;    ///< until when each counts as closed
  std::map<std::string, TimePoint> people_;   ///< until when each is checked in
  std::optional<Code> code_;
  std::vector<TimePoint> wrong_;  ///< when wrong codes were given, oldest first
  bool present_ = false;
  std::uint64_t spell_;
};

}  // namespace gecos::access
