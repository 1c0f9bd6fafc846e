#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "gecos/command.hpp"
#include "gecos/description.hpp"

namespace gecos::session {

/// Finds out from the calls of a program whether the program has a status of an object or asks for
/// one. The program counts as having the status from the request for it until the call that
/// releases it has ended, so also while the last commands under the status still run. Not
/// thread-safe.
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
  /// Requests that are open, or granted and not released.
  std::vector<std::shared_ptr<CommandCore>> requests_;
  /// Calls that release a status and are open.
  std::vector<std::shared_ptr<CommandCore>> releases_;
};

}  // namespace gecos::session
