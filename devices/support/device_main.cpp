#include "support/device_main.hpp"

#include <cstdio>
#include <exception>
#include <memory>

#include "support/periodic.hpp"

namespace devices {

int serve_device(gecos::Lab& lab, gecos::Servant& servant, const Served& how) {
  gecos::Server server(lab);
  gecos::ObjectOptions options;
  options.simulated = true;
  options.thread_safe = true;
  options.blocking = how.blocking;
  if (const auto served = server.add(how.name, servant, options); !served) {
    return fail(how.program, served.error().text);
  }
  std::vector<std::unique_ptr<Periodic>> beating;
  for (const Beat& beat : how.beats) {
    beating.push_back(std::make_unique<Periodic>(beat.period, beat.work));
  }
  std::printf("%s: %s is ready\n", how.program.c_str(), how.name.c_str());
  std::fflush(stdout);
  server.run();
  return 0;
}

int device_main(const char* program, const std::function<int()>& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    return fail(program, error.what());
  } catch (...) {  // KDL throws types of its own
    return fail(program, "something was thrown that is no std::exception");
  }
}

int fail(const std::string& program, const std::string& why) {
  std::fprintf(stderr, "%s: %s\n", program.c_str(), why.c_str());
  return 1;
}

}  // namespace devices
