#include "gecos/session/client/select.hpp"

#include <unistd.h>

#include <algorithm>

#include "gecos/base/user_and_host.hpp"
#include "gecos/media/kinds.hpp"

namespace gecos::session {

namespace {

std::optional<qos::RealTimeStatement> statement_about(std::string_view medium,
                                                      const StatedMedia& stated) {
  if (!stated) return qos::RealTimeStatement{false, stated.error()};
  const auto found = stated->find(medium);
  if (found == stated->end()) return std::nullopt;
  const auto& [real_time, place] = found->second;
  return qos::RealTimeStatement{real_time, place + " says that " + std::string(medium) +
                                               (real_time ? " is real-time" : " is not real-time")};
}

}  // namespace

qos::LineCapabilities line_of(const media::Capabilities& capabilities, const StatedMedia& stated) {
  qos::LineCapabilities line;
  line.name = capabilities.name;
  line.between_hosts = capabilities.reach == media::Reach::Network;
  line.reliable = true;  // if the medium loses packets, the session sends calls again
  line.keeps_samples = capabilities.reliable;
  line.real_time = capabilities.real_time;
  line.stated = statement_about(capabilities.name, stated);
  // Within one process, client and server die together, so no medium needs to report a death.
  line.reports_death = capabilities.reports_death || capabilities.reach == media::Reach::Process;
  return line;
}

qos::Quality demanded_of(qos::Quality asked, bool simulated,
                         const qos::RequestedQuality& requested) {
  if (!simulated) return qos::stricter(asked, requested);
  if (asked.line == qos::Class::HardRealtime) asked.line = qos::Class::SoftRealtime;
  asked.latency = {};
  return qos::stricter(asked, requested);
}

std::string medium_of(const std::string& address) { return address.substr(0, address.find(':')); }

namespace {

std::string out_of_shared_memory(Runtime& runtime, const Entry& entry, media::Kind kind,
                                 const std::string& address) {
  const std::string& here = runtime.host_identity();
  if (media::share_memory(entry.host, here) || media::open_to_this_user(entry.host)) return "";
  if (!media::on_one_machine(entry.host, here)) {
    return "the object is on another host (" + entry.hostname + ")";
  }
  if (const auto opened = runtime.medium(kind); !opened) return opened.error().text;
  const bool closed = !media::serves_all_users(entry.user);
  if (closed && !entry.user.empty() && entry.user != user_name(::geteuid())) {
    return "the server of the object runs as " + entry.user +
           "; programs of other users reach only " + std::string(media::servers_of_all_users) +
           " over shm";
  }
  return "the object is on this host, but in another runtime directory (" + address +
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

/// Returns the media that the server of the object `entry` offers, for example "inproc, shm".
std::string offered(const Entry& entry) {
  std::string media;
  for (const auto& address : entry.addresses) {
    media += (media.empty() ? "" : ", ") + medium_of(address);
  }
  return media.empty() ? "none" : media;
}

/// Appends to `media` the medium of `address` and the reason why it is not used, for example "shm:
/// the object is on another host".
void add_medium(std::string& media, const std::string& address, const std::string& why) {
  media += (media.empty() ? "" : "; ") + medium_of(address) + ": " + why;
}

/// Calls `look_at` with the quality that `wanted` demands, and with that of each of its members.
template <class LookAt>
void for_each_quality(const InterfaceDescription& wanted, LookAt look_at) {
  look_at(wanted.quality);
  for (const auto* each : wanted.all_operations()) look_at(each->quality);
  for (const auto* each : wanted.all_streams()) look_at(each->quality);
  for (const auto* each : wanted.all_inward_streams()) look_at(each->quality);
}

std::vector<qos::LineCapabilities> lines_of(const std::vector<Route>& routes) {
  std::vector<qos::LineCapabilities> lines;
  for (const Route& route : routes) lines.push_back(route.line);
  return lines;
}

}  // namespace

tl::expected<qos::LineCapabilities, std::string> line_to(Runtime& runtime, const Entry& entry,
                                                         const std::string& address,
                                                         const StatedMedia& stated) {
  const auto kind = media::kind_of(address);
  if (!kind) return tl::unexpected(std::string("this program does not know this medium"));
  if (auto why = out_of_reach(runtime, entry, *kind, address); !why.empty()) {
    return tl::unexpected(std::move(why));
  }
  const auto opened = runtime.medium(*kind);
  if (!opened) return tl::unexpected(opened.error().text);
  return line_of((*opened)->capabilities(), stated);
}

std::vector<UnsuitedMember> unsuited_members(const InterfaceDescription& interface,
                                             const qos::LineCapabilities& line, bool simulated,
                                             const qos::RequestedQuality& requested) {
  std::vector<UnsuitedMember> found;
  const auto check = [&](const auto& member, qos::Traffic traffic) {
    auto violated =
        qos::violations(demanded_of(member.quality, simulated, requested), line, traffic);
    if (violated.empty()) return;
    // A stream and its getter have the same code and often violate the same terms. The stream then
    // needs no entry of its own.
    const auto getter = std::ranges::find(found, member.code, &UnsuitedMember::code);
    if (getter != found.end() && getter->violations == violated) return;
    const bool samples_only =
        traffic == qos::Traffic::Samples && interface.find(member.code) != nullptr;
    found.push_back({member.code, std::string(member.name), std::move(violated), samples_only});
  };
  for (const auto* each : interface.all_operations()) check(*each, qos::Traffic::Calls);
  for (const auto* each : interface.all_streams()) check(*each, qos::Traffic::Samples);
  for (const auto* each : interface.all_inward_streams()) check(*each, qos::Traffic::Samples);
  return found;
}

bool demands_hard_real_time(const InterfaceDescription& wanted, bool simulated,
                            const qos::RequestedQuality& requested) {
  bool demanded = false;
  for_each_quality(wanted, [&](const qos::Quality& asked) {
    demanded |= demanded_of(asked, simulated, requested).line == qos::Class::HardRealtime;
  });
  return demanded;
}

Duration smallest_latency(const InterfaceDescription& wanted,
                          const qos::RequestedQuality& requested) {
  Duration smallest = Duration::max();
  for_each_quality(wanted, [&](const qos::Quality& asked) {
    if (qos::binds_latency(qos::stricter(asked, requested))) {
      smallest = std::min(smallest, asked.latency);
    }
  });
  return smallest == Duration::max() ? Duration::zero() : smallest;
}

Selection::Selection(Runtime& runtime, const Entry& entry, const qos::Quality& demanded,
                     const StatedMedia& stated, std::optional<media::Kind> only,
                     std::optional<media::Kind> without)
    : demanded_(demanded),
      asked_for_(only ? " over " + std::string(media::to_string(*only)) : ""),
      offered_(offered(entry)) {
  for (const auto& address : entry.addresses) {
    const auto kind = media::kind_of(address);
    if (only && kind && *kind != *only) continue;
    if (without && kind == without) {
      pass_over(address, "the connection over this medium became too slow");
    } else if (auto line = line_to(runtime, entry, address, stated)) {
      routes_.push_back({address, *std::move(line)});
    } else {
      pass_over(address, line.error());
      if (kind && media::reach_of(*kind) == media::Reach::Process) continue;
      add_medium(left_out_, address, line.error());
    }
  }
}

std::vector<Route> Selection::best_first() const {
  std::vector<Route> ranked;
  for (const std::size_t index : qos::rank(demanded_, lines_of(routes_))) {
    ranked.push_back(routes_[index]);
  }
  return ranked;
}

bool Selection::measured(const Route& route) {
  std::ranges::find(routes_, route.address, &Route::address)->line = route.line;
  return qos::violations(demanded_, route.line).empty();
}

void Selection::not_reached(const Route& route, const std::string& why) {
  std::erase_if(routes_, [&](const Route& each) { return each.address == route.address; });
  pass_over(route.address, why);
}

void Selection::pass_over(const std::string& address, const std::string& why) {
  add_medium(passed_over_, address, why);
}

std::string Selection::why_none() const {
  if (routes_.empty()) {
    return "cannot be reached" + asked_for_ +
           (passed_over_.empty() ? ": the server does not offer this medium; use " + offered_
                                 : " (" + passed_over_ + ")");
  }
  const auto chosen = qos::choose(demanded_, lines_of(routes_));
  return (chosen ? "" : chosen.error()) + (passed_over_.empty() ? "" : "; " + passed_over_);
}

}  // namespace gecos::session
