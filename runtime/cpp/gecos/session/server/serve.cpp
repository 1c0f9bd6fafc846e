#include "gecos/serve.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>

#include "gecos/media/waiting.hpp"
#include "gecos/session/process/termination_signals.hpp"

namespace gecos {
namespace {

using session::TerminationSignals;

constexpr Duration look_for_signals = std::chrono::milliseconds(200);

int fail(const ServeOptions& options, const std::string& why) {
  const std::string program = options.program.empty() ? "" : options.program + ": ";
  std::fprintf(stderr, "%s%s\n", program.c_str(), why.c_str());
  return 1;
}

void say_ready(const std::vector<Serving>& objects, const ServeOptions& options) {
  std::string line = options.ready;
  if (line.empty()) {
    for (const Serving& object : objects) line += (line.empty() ? "serving " : ", ") + object.name;
  }
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

bool came(const TerminationSignals& signals) {
  const int descriptors[] = {signals.descriptor()};
  return media::sleep_on(descriptors, std::chrono::steady_clock::now()) == media::Wake::Ready;
}

/// Waits for the broker. Returns false when a termination signal arrives first.
tl::expected<bool, ServeError> broker_found(Server& server, const std::vector<Serving>& objects,
                                            const TerminationSignals& signals) {
  Duration patience{};
  for (const Serving& object : objects) {
    if (!object.options.well_known) patience = std::max(patience, object.options.patience);
  }
  const TimePoint give_up = deadline_after(patience);
  while (patience > Duration{}) {
    if (came(signals)) return false;
    const Duration left = give_up - std::chrono::steady_clock::now();
    const auto found = server.await_broker(std::clamp(left, Duration{}, look_for_signals));
    if (found) return true;
    if (std::chrono::steady_clock::now() >= give_up) return tl::unexpected(found.error());
  }
  return true;
}

int serve_until_signal(Lab& lab, const std::vector<Serving>& objects, const ServeOptions& options) {
  Server server(lab, options.admission);
  if (!options.users.empty() || !options.hosts.empty()) server.allow(options.users, options.hosts);
  std::shared_ptr<void> started;
  const TerminationSignals
      signals;  // destroyed before the server, so that a signal ends the program meanwhile
  const auto found = broker_found(server, objects, signals);
  if (!found) return fail(options, objects.front().name + " is not served: " + found.error().text);
  if (!*found) return 0;
  for (const Serving& object : objects) {
    const auto added = server.add(object.name, object.servant, object.options);
    if (!added) return fail(options, added.error().text);
  }
  if (options.started) started = options.started();
  say_ready(objects, options);
  server.run();
  return 0;
}

}  // namespace

int serve(Lab& lab, const std::vector<Serving>& objects, const ServeOptions& options) {
  try {
    return serve_until_signal(lab, objects, options);
  } catch (const std::exception& error) {
    return fail(options, error.what());
  } catch (...) {
    return fail(options, "the program threw something that is not a std::exception");
  }
}

}  // namespace gecos
