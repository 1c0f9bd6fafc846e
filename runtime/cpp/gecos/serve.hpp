#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gecos/server.hpp"

namespace gecos {

/// One object of `serve`.
struct Serving {
  std::string name;
  Servant& servant;
  ObjectOptions options{};
};

struct ServeOptions {
  /// Begins what is said on stderr: "robcl-rx90: …". Empty: nothing does.
  std::string program{};
  /// The line on stdout once all objects are served. Empty: "serving RX90, GRIPPER".
  std::string ready{};
  /// Called once all objects are served, before the line that says so. What it gives is kept until
  /// the signal, and destroyed before the objects are withdrawn: the threads that publish, say.
  std::function<std::shared_ptr<void>()> started{};
};

/// Serves objects until SIGINT or SIGTERM; the last line of a `main`, whose exit status it gives.
///
/// The signals are its own from the beginning, so that none ends the program without a goodbye; the
/// next one, while the objects are withdrawn, ends the program even when a handler hangs. Waits for
/// a broker that is starting (`ObjectOptions::patience`) and prints one line once a client can
/// reach all objects. Why one is not served, or what was thrown, of whatever type, is one line on
/// stderr and the status 1.
int serve(Lab& lab, const std::vector<Serving>& objects, const ServeOptions& options = {});

}  // namespace gecos
