#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "gecos/command.hpp"
#include "gecos/description.hpp"

namespace gecos::session {

/// Knows from the calls of a program whether the program has a status of an object or asks for one.
/// The status counts from the request for it until the call that releases it has ended, so also
/// while its commands drain. Not thread-safe.
class StatusUse {
 public:
  /// Returns whether calls of `operation` acquire or release a status. For these, begin() must be
  /// called before the call is issued, and issued() after it.
  static bool concerns(FunctionCode operation);
  void begin() { ++begun_; }
  void issued(FunctionCode operation, std::shared_ptr<CommandCore> command);
  bool in_use();

 private:
  std::size_t begun_ = 0;                               ///< calls that are being issued
  std::vector<std::shared_ptr<CommandCore>> requests_;  ///< open, or granted and not released
  std::vector<std::shared_ptr<CommandCore>> releases_;  ///< open
};

}  // namespace gecos::session
