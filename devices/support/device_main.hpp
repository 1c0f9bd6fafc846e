// The code that all device programs share: it serves a servant, and reports errors in `main`.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "gecos/gecos.hpp"

namespace devices {

/// Periodic work of a device: it publishes, and connects to other objects. While the device is
/// served, the work runs on a separate thread.
struct Beat {
  /// The period in simulated time, as `LabClock` counts it. If simulated time is slower than real
  /// time, the period is this value in real time. If simulated time is faster, the period in real
  /// time is shorter than this value, but not shorter than `shortest`, because no reader needs
  /// samples more often.
  gecos::Duration period;
  std::function<void()> work;
  static constexpr gecos::Duration shortest = std::chrono::milliseconds(1);
};

struct Served {
  std::string program;  ///< begins each line that is printed, for example "robcl-rx90"
  std::string name;     ///< name under which clients find the object
  bool simulated = true;
  double clock = 1;  ///< speed of the device's LabClock
  gecos::Admission admission = gecos::Admission::Listed;
  /// True if handlers wait for other objects. The handlers then run on the executor of the object
  /// and not on the I/O loop.
  bool blocking = false;
  std::vector<Beat> beats{};  ///< started once the object is served
};

/// Serves `servant` until the program gets SIGINT or SIGTERM. Prints one line when the object is
/// ready, or the reason why the object cannot be served. Returns the program's exit status. @pre
/// `servant` is thread-safe.
int serve_device(gecos::Lab& lab, gecos::Servant& servant, const Served& how);

/// Calls `work` and returns its result, for `main`. If `work` throws, prints one line on stderr and
/// returns the exit status 1.
int device_main(const char* program, const std::function<int()>& work);

/// Prints a line such as "robcl-rx90: …" with the reason `why` on stderr, and returns the exit
/// status 1.
int fail(const std::string& program, const std::string& why);

}  // namespace devices
