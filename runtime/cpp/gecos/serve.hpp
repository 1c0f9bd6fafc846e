#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gecos/server.hpp"

namespace gecos {

/// One object that `serve` is to serve.
struct Serving {
  std::string name;
  Servant& servant;
  ObjectOptions options{};
};

struct ServeOptions {
  /// Prefix of the lines on stderr: "robcl-rx90: …". Empty: no prefix.
  std::string program{};
  /// The line on stdout once all objects are served. Empty: "serving RX90, GRIPPER".
  std::string ready{};
  /// Called once all objects are served, before the `ready` line is printed. May return something
  /// to keep, for example the publishing threads. `serve` destroys it after the signal, before it
  /// withdraws the objects.
  std::function<std::shared_ptr<void>()> started{};
};

/// Serves objects until SIGINT or SIGTERM. Use it as the last line of `main`: it returns the exit
/// status.
///
/// It handles both signals from the beginning, so that no signal ends the program without a
/// goodbye. A second signal, while the objects are withdrawn, ends the program even when a handler
/// hangs. Waits for a broker that is starting (`ObjectOptions::patience`) and prints one line once
/// clients can reach all objects. When an object cannot be served, or an exception of any type is
/// thrown, it prints one line on stderr and returns 1.
int serve(Lab& lab, const std::vector<Serving>& objects, const ServeOptions& options = {});

}  // namespace gecos
