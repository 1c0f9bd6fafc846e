#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gecos/server.hpp"

namespace gecos {

/// An object for `serve`.
struct Serving {
  std::string name;
  Servant& servant;
  ObjectOptions options{};
};

struct ServeOptions {
  /// The name of the program, with which the lines on stderr begin, for example "robcl-rx90: …".
  /// Empty: the lines have no prefix.
  std::string program{};
  /// The line that `serve` prints on stdout once all objects are served. Empty: a line with the
  /// names of the objects, for example "serving RX90, GRIPPER".
  std::string ready{};
  /// The users and hosts that may connect in addition to the user of this process on this host, as
  /// in Server::allow. If both lists are empty, the lab file alone decides.
  std::vector<std::string> users{};
  std::vector<std::string> hosts{};
  /// Admission::Insecure admits every user and host to simulated objects. Set it only for a flag
  /// that a person gives to the program, never for an environment variable.
  Admission admission = Admission::Listed;
  /// Called once all objects are served, before the `ready` line is printed. May return an object
  /// to keep alive, for example one that owns the publishing threads. `serve` destroys that object
  /// after the signal, before it withdraws the served objects.
  std::function<std::shared_ptr<void>()> started{};
};

/// Serves objects until SIGINT or SIGTERM. Use it as the last line of `main`: it returns the exit
/// status.
///
/// `serve` handles both signals from its beginning, so that neither signal ends the program before
/// clients and broker are told. While `serve` withdraws the objects, a second signal ends the
/// program, even when a handler hangs. `serve` waits for a broker that is starting, for at most
/// `ObjectOptions::patience`. It prints one line once clients can reach all objects. When an object
/// cannot be served, or an exception of any type is thrown, it prints one line on stderr and
/// returns 1.
int serve(Lab& lab, const std::vector<Serving>& objects, const ServeOptions& options = {});

}  // namespace gecos
