#include "gecos/session/client/select.hpp"

#include <algorithm>

#include "gecos/media/kinds.hpp"

namespace gecos::session {

qos::LineCapabilities line_of(const media::Capabilities& capabilities) {
  qos::LineCapabilities line;
  line.name = capabilities.name;
  line.between_hosts = capabilities.reach == media::Reach::Network;
  line.reliable = true;  // when the medium loses packets, the session sends them again
  line.real_time = capabilities.real_time;
  // Within one process, client and server die together, so no medium needs to report a death.
  line.reports_death = capabilities.reports_death || capabilities.reach == media::Reach::Process;
  return line;
}

qos::Quality demanded_of(qos::Quality asked, bool simulated) {
  if (simulated && asked.line == qos::Class::HardRealtime) asked.line = qos::Class::SoftRealtime;
  return asked;
}

namespace {

std::string out_of_shared_memory(Runtime& runtime, const Entry& entry, media::Kind kind,
                                 const std::string& address) {
  const std::string& here = runtime.host_identity();
  if (media::share_memory(entry.host, here)) return "";
  if (!media::on_one_machine(entry.host, here)) {
    return "it is on another host (" + entry.hostname + ")";
  }
  if (const auto opened = runtime.medium(kind); !opened) return opened.error().text;
  return "it is on this host, in another runtime directory (" + address +
         "): for shm, both programs must run as one user with the same GECOS_RUNTIME_DIR";
}

/// Returns why this program cannot reach the object at `address` over the medium `kind`; an empty
/// text when it can.
std::string out_of_reach(Runtime& runtime, const Entry& entry, media::Kind kind,
                         const std::string& address) {
  switch (media::reach_of(kind)) {
    case media::Reach::Process:
      return entry.boot == number(process_incarnation()) ? "" : "it is in another process";
    case media::Reach::Host:
      return out_of_shared_memory(runtime, entry, kind, address);
    case media::Reach::Network:
      return "";
  }
  return "this program does not know this medium";
}

/// The media that the server of an object offers: "inproc, shm".
std::string offered(const Entry& entry) {
  std::string media;
  for (const auto& address : entry.addresses) {
    media += (media.empty() ? "" : ", ") + address.substr(0, address.find(':'));
  }
  return media.empty() ? "none" : media;
}

}  // namespace

tl::expected<std::vector<std::string>, std::string> select(Runtime& runtime, const Entry& entry,
                                                           const qos::Quality& asked,
                                                           std::optional<media::Kind> only) {
  std::vector<std::string> addresses;
  std::vector<qos::LineCapabilities> lines;
  std::string reasons;
  const auto pass_over = [&](std::string_view medium, const std::string& why) {
    reasons += (reasons.empty() ? "" : "; ") + std::string(medium) + ": " + why;
  };
  for (const auto& address : entry.addresses) {
    const std::string medium = address.substr(0, address.find(':'));
    const auto kind = media::kind_of(address);
    if (!kind) {
      pass_over(medium, "this program does not know this medium");
      continue;
    }
    if (only && *kind != *only) continue;
    if (const auto why = out_of_reach(runtime, entry, *kind, address); !why.empty()) {
      pass_over(medium, why);
    } else if (const auto opened = runtime.medium(*kind); !opened) {
      pass_over(medium, opened.error().text);
    } else {
      addresses.push_back(address);
      lines.push_back(line_of((*opened)->capabilities()));
    }
  }
  if (addresses.empty()) {
    const std::string asked_for = only ? " over " + std::string(media::to_string(*only)) : "";
    return tl::unexpected("cannot be reached" + asked_for +
                          (reasons.empty()
                               ? ": its server does not offer this medium; use " + offered(entry)
                               : " (" + reasons + ")"));
  }
  const qos::Quality demanded = demanded_of(asked, entry.simulated);
  if (const auto chosen = qos::choose(demanded, lines); !chosen) {
    return tl::unexpected(chosen.error() + (reasons.empty() ? "" : "; " + reasons));
  }
  std::vector<std::string> ranked;
  for (const std::size_t index : qos::rank(demanded, lines)) ranked.push_back(addresses[index]);
  return ranked;
}

}  // namespace gecos::session
