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

  /// Must be called before the object is registered where other processes find it: from now on
  /// actor commands need the broker's confirmation of the name.
  void ask();
  /// The number of the current question to the broker; only its answer counts.
  std::uint64_t question();

  // The broker's answers.
  void held(std::uint64_t question);
  void provisional();
  void unanswered(std::uint64_t question, const std::string& why);
  /// Another server, `by`, has the name: ends the leases and stops the object.
  void taken(const std::string& by);

 private:
  HostState& object_;
};

}  // namespace gecos::session
