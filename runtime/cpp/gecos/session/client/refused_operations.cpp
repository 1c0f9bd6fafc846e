#include "gecos/session/client/refused_operations.hpp"

#include <algorithm>

#include "gecos/session/client/select.hpp"

namespace gecos::session {

void RefusedOperations::check_quality(const InterfaceDescription& wanted,
                                      const qos::LineCapabilities& line, bool simulated) {
  medium_ = line.name;
  for (const auto& [code, name, violations] : unsuited_members(wanted, line, simulated)) {
    unsuited_.push_back({code, to_string(violations)});
  }
  std::ranges::stable_sort(unsuited_, {}, &Unsuited::code);
}

std::optional<Failure> RefusedOperations::why(FunctionCode code, std::string_view name,
                                              const Welcome& server,
                                              std::string_view outcome) const {
  const auto what = [&] {
    return "'" + std::string(name) + "' of " + server.object + " " + std::string(outcome);
  };
  if (std::ranges::binary_search(differing_, code)) {
    return Failure{
        Detail::Refused,
        what() + ": the server's " + server.interface_name +
            " defines this operation differently than this program; rebuild the older of the two "
            "from the newer interface (`gidl breaking` shows what differs)",
        {},
        {}};
  }
  const auto found = std::ranges::lower_bound(unsuited_, code, {}, &Unsuited::code);
  if (found == unsuited_.end() || found->code != code) return std::nullopt;
  return Failure{
      Detail::QosUnavailable,
      what() + " over " + medium_ + ": " + found->terms + "; create the proxy over another medium",
      {},
      {}};
}

}  // namespace gecos::session
