#include "gecos/broker/names.hpp"

#include <algorithm>

#include "gecos/access/access_policy.hpp"

namespace gecos::broker {

std::string why_not_listed(const Entry& what, const std::optional<AdmittedNames>& admitted) {
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  const auto longest = std::to_string(longest_name) + " bytes";
  if (what.name.empty() || what.name.size() > longest_name || what.name == access::broker_object ||
      std::ranges::any_of(what.name, is_control)) {
    return "the name of an object has 1 to " + longest +
           " without control characters, and is not BROKER; give the object another name";
  }
  const auto is_long = [](const std::string& name) { return name.size() > longest_name; };
  if (admitted && (std::ranges::any_of(admitted->users, is_long) ||
                   std::ranges::any_of(admitted->hosts, is_long))) {
    return "a user or host whom the program of " + what.name + " admits has a name of more than " +
           longest + "; correct Server::allow";
  }
  return {};
}

}  // namespace gecos::broker
