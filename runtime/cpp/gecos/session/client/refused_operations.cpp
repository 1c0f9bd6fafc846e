#include "gecos/session/client/refused_operations.hpp"

#include <algorithm>

#include "gecos/session/client/select.hpp"

namespace gecos::session {

void RefusedOperations::check_quality(const InterfaceDescription& wanted,
                                      const media::Capabilities& medium, bool simulated) {
  const qos::LineCapabilities line = line_of(medium);
  medium_ = line.name;
  const auto check = [&](FunctionCode code, const qos::Quality& asked) {
    std::string terms;
    for (const auto& [term, why] : qos::violations(demanded_of(asked, simulated), line)) {
      terms += (terms.empty() ? "" : "; ") + term + ": " + why;
    }
    if (!terms.empty()) unsuited_.push_back({code, std::move(terms)});
  };
  for (const auto* operation : wanted.all_operations()) check(operation->code, operation->quality);
  for (const auto* stream : wanted.all_streams()) check(stream->code, stream->quality);
  for (const auto* stream : wanted.all_inward_streams()) check(stream->code, stream->quality);
  std::ranges::stable_sort(unsuited_, {}, &Unsuited::code);
}

std::optional<Failure> RefusedOperations::why(FunctionCode code, std::string_view name,
                                              const Welcome& server) const {
  const auto what = [&] {
    return "'" + std::string(name) + "' of " + server.object + " was not sent";
  };
  if (std::ranges::binary_search(differing_, code)) {
    return Failure{Detail::Refused,
                   what() + ": the server's " + server.interface_name +
                       " defines it differently than this program; rebuild the older of the two "
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
