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

std::string medium_of(const std::string& address) { return address.substr(0, address.find(':')); }

namespace {

std::string out_of_shared_memory(Runtime& runtime, const Entry& entry, media::Kind kind,
                                 const std::string& address) {
  const std::string& here = runtime.host_identity();
  if (media::share_memory(entry.host, here) || media::open_to_this_user(entry.host)) return "";
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
    media += (media.empty() ? "" : ", ") + medium_of(address);
  }
  return media.empty() ? "none" : media;
}

}  // namespace

tl::expected<qos::LineCapabilities, std::string> line_to(Runtime& runtime, const Entry& entry,
                                                         const std::string& address) {
  const auto kind = media::kind_of(address);
  if (!kind) return tl::unexpected(std::string("this program does not know this medium"));
  if (auto why = out_of_reach(runtime, entry, *kind, address); !why.empty()) {
    return tl::unexpected(std::move(why));
  }
  const auto opened = runtime.medium(*kind);
  if (!opened) return tl::unexpected(opened.error().text);
  return line_of((*opened)->capabilities());
}

std::vector<UnsuitedMember> unsuited_members(const InterfaceDescription& interface,
                                             const qos::LineCapabilities& line, bool simulated) {
  std::vector<UnsuitedMember> found;
  const auto check = [&](const auto& member) {
    auto violated = qos::violations(demanded_of(member.quality, simulated), line);
    if (violated.empty()) return;
    found.push_back({member.code, std::string(member.name), std::move(violated)});
  };
  for (const auto* operation : interface.all_operations()) check(*operation);
  for (const auto* stream : interface.all_streams()) {
    // A stream has the quality and the code of its getter.
    if (std::ranges::find(found, stream->code, &UnsuitedMember::code) == found.end())
      check(*stream);
  }
  for (const auto* stream : interface.all_inward_streams()) check(*stream);
  return found;
}

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
    const auto kind = media::kind_of(address);
    if (only && kind && *kind != *only) continue;
    if (auto line = line_to(runtime, entry, address)) {
      addresses.push_back(address);
      lines.push_back(*std::move(line));
    } else {
      pass_over(medium_of(address), line.error());
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
