#include "gecos/broker/others.hpp"

#include <exception>
#include <stdexcept>

#include "gecos/base/log.hpp"
#include "gecos/session/lab_core.hpp"
#include "gecos/session/linked_session.hpp"
#include "gecos/session/registry.hpp"

namespace gecos::broker {

std::vector<std::string> other_brokers(Duration patience) {
  std::vector<std::string> places;
  Lab lab;
  if (!lab.core()) throw std::runtime_error(lab.core().error().text);
  session::Runtime& runtime = *(*lab.core())->runtime();
  for (const media::Kind kind : {media::Kind::Shm, media::Kind::Lcm}) {
    const auto medium = runtime.medium(kind);
    if (!medium) continue;
    const std::string place = (*medium)->well_known_address(session::broker_name);
    const auto found =
        runtime.connect(place, session::broker_interface(), deadline_after(patience));
    if (!found) continue;
    if ((*found)->welcome().boot != number(session::process_boot())) places.push_back(place);
    (*found)->close(patience);
  }
  return places;
}

void warn_of_other_brokers() try {
  for (const auto& place : other_brokers(std::chrono::milliseconds(500))) {
    log_warning("broker", "another broker answers at " + place +
                              ": a name is unique at each of them only. Programs use the one of "
                              "this host's socket unless GECOS_BROKER says otherwise; end one of "
                              "them, or set GECOS_BROKER for all programs");
  }
} catch (const std::exception& failed) {  // no threads or descriptors
  log_warning("broker", std::string("other brokers were not looked for: ") + failed.what());
}

}  // namespace gecos::broker
