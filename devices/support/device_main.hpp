// The common part of every device program, around its servant.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gecos/gecos.hpp"

namespace devices {

/// Work of a device that goes on while it is served, each on a thread of its own.
struct Beat {
  gecos::Duration period;
  std::function<void(double seconds)> work;  ///< gets the time since its last call, s
};

struct Served {
  std::string program;  ///< "robcl-rx90": begins each line that is printed
  std::string name;     ///< to register
  bool simulated = true;
  /// Handlers wait for other objects: each runs on the object's worker.
  bool blocking = false;
  std::vector<Beat> beats{};  ///< started once it is served
};

/// Serves a thread-safe `servant` until SIGINT or SIGTERM. Prints one line when it is
/// ready, and why it cannot be served. Gives the program's exit status.
int serve_device(gecos::Lab& lab, gecos::Servant& servant, const Served& how);

/// The body of `main`: whatever `work` throws, of whatever type, is one line on stderr and the exit
/// status 1.
int device_main(const char* program, const std::function<int()>& work);

/// One line on stderr, "robcl-rx90: …"; gives the exit status 1.
int fail(const std::string& program, const std::string& why);

}  // namespace devices
