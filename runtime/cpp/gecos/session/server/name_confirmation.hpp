#pragma once

#include <cstdint>
#include <string>

namespace gecos::session {

struct HostState;

/// Tells one object whether the broker confirms that the object has its name (name_claim.hpp).
/// Thread-safe.
class NameConfirmation {
 public:
  explicit NameConfirmation(HostState& object) : object_(object) {}

  /// Begins a new question to the broker: from now on actor commands need the broker's confirmation
  /// of the name. Must be called before the object is registered with a broker through which other
  /// processes can find it.
  void ask();
  /// Returns the number of the current question to the broker. Only an answer to this question
  /// counts.
  std::uint64_t question();

  // The functions below record an answer of the broker.
  void held(std::uint64_t question);
  void provisional();
  void unanswered(std::uint64_t question, const std::string& why);
  /// Records that another server has the name; `by` describes that server. Ends the leases and
  /// stops the object.
  void taken(const std::string& by);

 private:
  HostState& object_;
};

}  // namespace gecos::session
