#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "gecos/command.hpp"
#include "gecos/description.hpp"

namespace gecos::session {

/// Finds out from the calls of a program whether the program has a status of an object or asks for
/// one. From the request for a status until the end of the call that releases the status, the
/// program counts as having the status. This includes the time in which the last commands under the
/// status still run. Not thread-safe.
class StatusUse {
 public:
  /// Returns whether calls of `operation` acquire or release a status. Before such a call is
  /// issued, begin() must be called; after the call was issued, issued() must be called.
  static bool concerns(FunctionCode operation);
  void begin() { ++begun_; }
  void issued(FunctionCode operation, std::shared_ptr<CommandCore> command);
  bool in_use();

 private:
  std::size_t begun_ = 0;  ///< calls that are being issued
  /// The requests for a status that have no reply yet, and those that were granted and whose status
  /// is not released.
  std::vector<std::shared_ptr<CommandCore>> requests_;
  /// The calls that release a status and have no reply yet.
  std::vector<std::shared_ptr<CommandCore>> releases_;
};

}  // namespace gecos::session
