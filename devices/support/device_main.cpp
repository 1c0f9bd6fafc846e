#include "devices/support/device_main.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>

#include "devices/support/periodic.hpp"
#include "gecos/serve.hpp"

namespace devices {
namespace {

gecos::Duration real_period(const Beat& beat, double clock) {
  const auto simulated = std::chrono::duration<double>(beat.period) / clock;
  const auto real = std::chrono::round<gecos::Duration>(simulated);
  return std::clamp(real, std::min(Beat::shortest, beat.period), beat.period);
}

/// Returns the line that says that the device is ready and, for a LabClock with another speed than
/// 1, how fast its simulated time is.
std::string ready_line(const Served& how) {
  char clock[80] = "";
  if (how.clock != 1) {
    std::snprintf(clock, sizeof clock, "simulated time is %g times as fast as real time; ",
                  how.clock);
  }
  return how.program + ": " + clock + how.name + " is ready";
}

}  // namespace

int serve_device(gecos::Lab& lab, gecos::Servant& servant, const Served& how) {
  gecos::ObjectOptions object;
  object.simulated = how.simulated;
  object.thread_safe = true;
  object.blocking = how.blocking;
  gecos::ServeOptions options;
  options.program = how.program;
  options.ready = ready_line(how);
  options.admission = how.admission;
  options.started = [&how] {
    auto beating = std::make_shared<std::vector<std::unique_ptr<Periodic>>>();
    for (const Beat& beat : how.beats) {
      beating->push_back(std::make_unique<Periodic>(real_period(beat, how.clock),
                                                    [work = beat.work](double) { work(); }));
    }
    return beating;
  };
  return gecos::serve(lab, {{how.name, servant, object}}, options);
}

int device_main(const char* program, const std::function<int()>& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    return fail(program, error.what());
  } catch (...) {  // KDL's exceptions do not derive from std::exception
    return fail(program, "stopped by an exception that is not a std::exception");
  }
}

int fail(const std::string& program, const std::string& why) {
  std::fprintf(stderr, "%s: %s\n", program.c_str(), why.c_str());
  return 1;
}

}  // namespace devices
