#include "gecos/session/client/refused_operations.hpp"

#include <algorithm>

#include "gecos/session/client/select.hpp"

namespace gecos::session {

void RefusedOperations::check_quality(const InterfaceDescription& wanted,
                                      const qos::LineCapabilities& line, bool simulated,
                                      const qos::RequestedQuality& requested) {
  medium_ = line.name;
  for (const UnsuitedMember& member : unsuited_members(wanted, line, simulated, requested)) {
    std::string terms = to_string(member.violations);
    if (!member.samples_only) calls_.push_back({member.code, terms});
    // If the getter of a stream is refused, the stream is refused, too. If the stream has an entry
    // of its own, that entry follows; it lists all violated terms and replaces the entry of the
    // getter.
    std::erase_if(streams_, [&](const Unsuited& each) { return each.code == member.code; });
    streams_.push_back({member.code, std::move(terms)});
  }
  std::ranges::sort(calls_, {}, &Unsuited::code);
  std::ranges::sort(streams_, {}, &Unsuited::code);
}

std::optional<Failure> RefusedOperations::why(FunctionCode code, std::string_view name,
                                              const Welcome& server, qos::Traffic traffic) const {
  const bool called = traffic == qos::Traffic::Calls;
  const auto what = [&] {
    return "'" + std::string(name) + "' of " + server.object +
           (called ? " was not sent" : " was not opened");
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
  const std::vector<Unsuited>& unsuited = called ? calls_ : streams_;
  const auto found = std::ranges::lower_bound(unsuited, code, {}, &Unsuited::code);
  if (found == unsuited.end() || found->code != code) return std::nullopt;
  return Failure{
      Detail::QosUnavailable,
      what() + " over " + medium_ + ": " + found->terms + "; create the proxy over another medium",
      {},
      {}};
}

}  // namespace gecos::session
