#include "gecos/broker/names.hpp"

#include <algorithm>

#include "gecos/access/access_policy.hpp"

namespace gecos::broker {

std::string why_not_listed(const Entry& what, const std::optional<AdmittedNames>& admitted) {
  if (!access::fault_of_name(what.name).empty() || what.name == access::broker_object) {
    return "the name of an object has 1 to " + std::to_string(access::longest_name) +
           " bytes without control characters, and is not BROKER; give the object another name";
  }
  if (!admitted) return {};
  for (const auto* const names : {&admitted->users, &admitted->hosts}) {
    for (const auto& name : *names) {
      const auto fault = access::fault_of_name(name);
      if (fault.empty()) continue;
      return "the list of users and hosts that the server of " + what.name +
             " admits has a name that " + std::string(fault) +
             "; correct the list in its program or in its lab file";
    }
  }
  return {};
}

}  // namespace gecos::broker
