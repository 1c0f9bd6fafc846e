#include "devices/support/device_main.hpp"

#include <cstdio>
#include <exception>
#include <memory>

#include "devices/support/periodic.hpp"
#include "gecos/serve.hpp"

namespace devices {

int serve_device(gecos::Lab& lab, gecos::Servant& servant, const Served& how) {
  gecos::ObjectOptions object;
  object.simulated = how.simulated;
  object.thread_safe = true;
  object.blocking = how.blocking;
  gecos::ServeOptions options;
  options.program = how.program;
  options.ready = how.program + ": " + how.name + " is ready";
  options.started = [&how] {
    auto beating = std::make_shared<std::vector<std::unique_ptr<Periodic>>>();
    for (const Beat& beat : how.beats) {
      beating->push_back(std::make_unique<Periodic>(beat.period, beat.work));
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
