#include "gecos/broker/others.hpp"

#include <exception>
#include <stdexcept>

#include "gecos/base/log.hpp"
#include "gecos/binding.hpp"

namespace gecos::broker {

std::vector<std::string> other_brokers(Duration patience) {
  std::vector<std::string> places;
  Lab lab;
  const session::LabOrWhyNot& context = session::LabAccess::context(lab);
  if (!context) throw std::runtime_error(context.error().text);
  for (auto& found : session::find_brokers(context, patience)) {
    if (found.incarnation != session::process_incarnation())
      places.push_back(std::move(found.address));
  }
  return places;
}

void warn_of_other_brokers() try {
  for (const auto& place : other_brokers(std::chrono::milliseconds(500))) {
    log_warning("broker", "another broker answers at " + place +
                              ": object names are unique only within one broker. Programs use "
                              "the broker at this host's local address unless GECOS_BROKER or "
                              "the lab file names another one. End one of the brokers, or name "
                              "one of them for all programs");
  }
} catch (const std::exception& failed) {  // no threads or descriptors are left
  log_warning("broker", std::string("cannot search for other brokers: ") + failed.what());
}

}  // namespace gecos::broker
