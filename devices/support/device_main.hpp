// The part that all device programs share: serving one servant, and errors in `main`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gecos/gecos.hpp"

namespace devices {

/// Periodic work of a device while it is served, on a thread of its own.
struct Beat {
  gecos::Duration period;
  std::function<void(double seconds)> work;  ///< argument: time since the last call, s
};

struct Served {
  std::string program;  ///< "robcl-rx90": begins each line that is printed
  std::string name;     ///< name to register
  bool simulated = true;
  /// Whether handlers wait for other objects; then each handler runs on the object's worker.
  bool blocking = false;
  std::vector<Beat> beats{};  ///< started once the object is served
};

/// Serves a thread-safe `servant` until SIGINT or SIGTERM. Prints one line when it is ready, or the
/// reason why it cannot be served. Returns the program's exit status.
int serve_device(gecos::Lab& lab, gecos::Servant& servant, const Served& how);

/// The body of `main`. An exception of any type from `work` becomes one line on stderr and exit
/// status 1.
int device_main(const char* program, const std::function<int()>& work);

/// Prints one line on stderr, "robcl-rx90: …", and returns exit status 1.
int fail(const std::string& program, const std::string& why);

}  // namespace devices
