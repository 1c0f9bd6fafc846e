#include "gecos/access/access_policy.hpp"

#include <algorithm>
#include <iterator>

namespace gecos::access {
namespace {

bool names(const std::vector<std::string>& list, const std::string& name) {
  return std::ranges::any_of(list, [&](const auto& one) { return one == name || one == everyone; });
}

/// Returns the reason for which `list` refuses `who`; no value when `list` admits `who`.
std::optional<AccessRule> refusal_of(const AllowList& list, const UserAtHost& server,
                                     const UserAtHost& who) {
  if (who.user != server.user && !names(list.users, who.user)) return AccessRule::UserNotNamed;
  if (who.host != server.host && !names(list.hosts, who.host)) return AccessRule::HostNotNamed;
  return std::nullopt;
}

/// Returns the rule that admits `who` regardless of the lists; no value if only a list can admit
/// `who`.
std::optional<AccessRule> admitted_without_list(const UserAtHost& server, const UserAtHost& who) {
  if (who == server) return AccessRule::OwnUser;
  if (who == UserAtHost{"root", server.host}) return AccessRule::Root;
  return std::nullopt;
}

std::vector<std::string> names_in_both(const std::vector<std::string>& one,
                                       const std::vector<std::string>& other) {
  if (names(one, std::string(everyone))) return other;
  std::vector<std::string> both;
  std::ranges::copy_if(one, std::back_inserter(both),
                       [&](const auto& name) { return names(other, name); });
  return both;
}

std::string words(const UserAtHost& who) { return "user " + who.user + " of host " + who.host; }

AccessDecision admit(AccessRule rule, const UserAtHost& who, std::string_view object,
                     const std::string& because) {
  return {rule, std::string(object) + " admits " + words(who) + ": " + because};
}

AccessDecision refuse(AccessRule rule, const UserAtHost& who, std::string_view object,
                      const std::string& because) {
  return {rule, std::string(object) + " refuses " + words(who) + ": " + because};
}

AccessDecision refuse(AccessRule rule, const AllowList& list, const UserAtHost& who,
                      std::string_view object) {
  const bool user = rule == AccessRule::UserNotNamed;
  const std::string& missing = user ? who.user : who.host;
  return refuse(rule, who, object,
                list.place + " does not name " + (user ? "user " : "host ") + missing + "; add \"" +
                    missing + "\" to its " + (user ? "users" : "hosts"));
}

/// Returns the list of the lab file that decides whether `who` may connect to the broker, when the
/// file has no list for the broker itself: the first list that admits `who`. If no list admits
/// `who`, returns the first list of the file.
const AllowList* list_of_broker(const LabAccess& lab, const UserAtHost& server,
                                const UserAtHost& who) {
  const AllowList* first = lab.general ? &*lab.general : nullptr;
  if (first != nullptr && !refusal_of(*first, server, who)) return first;
  for (const auto& [name, list] : lab.objects) {
    if (!refusal_of(list, server, who)) return &list;
    if (first == nullptr) first = &list;
  }
  return first;
}

/// Returns the list of the lab file that holds for `object`, which is not the broker.
const AllowList* list_of(const LabAccess& lab, std::string_view object) {
  const auto own = lab.objects.find(std::string(object));
  if (own != lab.objects.end()) return &own->second;
  return lab.general ? &*lab.general : nullptr;
}

const AllowList* list_of(const LabAccess& lab, const UserAtHost& server, const UserAtHost& who,
                         std::string_view object) {
  const bool broker = object == broker_object && !lab.objects.contains(std::string(object));
  return broker ? list_of_broker(lab, server, who) : list_of(lab, object);
}

AccessDecision nobody_named(const LabAccess& lab, const UserAtHost& server, const UserAtHost& who,
                            std::string_view object) {
  const bool here = who.host == server.host;
  const std::string line =
      here ? "users = [\"" + who.user + "\"]"
           : (who.user == server.user ? "" : "users = [\"" + who.user + "\"], ") + "hosts = [\"" +
                 who.host + "\"]";
  const std::string file = lab.file.empty() ? "a lab file (GECOS_LAB_FILE)" : lab.file;
  return refuse(AccessRule::NobodyNamed, who, object,
                std::string(object) + " admits only " + words(server) + "; write " + line +
                    " below [allow] in " + file);
}

}  // namespace

std::string_view fault_of_name(std::string_view name) {
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  if (name.empty()) return "is empty";
  if (name.size() > longest_name) return "has more than 256 bytes";
  if (std::ranges::any_of(name, is_control)) return "has a control character";
  return {};
}

NameDecision may_register(const LabAccess& lab, const std::string& name,
                          const std::optional<UserAtHost>& who) {
  const auto bound = lab.names.find(name);
  if (bound == lab.names.end()) {
    return {true, "any server that the broker admits may register " + name +
                      ": no [names] of a lab file binds this name"};
  }
  const auto& [owner, place] = bound->second;
  const std::string rule = place + " binds this name to " + words(owner);
  if (!who) {
    return {false, "a server whose key has no owner may not register " + name + ": " + rule +
                       "; name the owner of the key at the broker: gecos keys add FILE " +
                       owner.user + "@" + owner.host};
  }
  const std::string server = "a server of " + words(*who);
  if (*who == owner) return {true, server + " may register " + name + ": " + rule};
  return {false, server + " may not register " + name + ": " + rule +
                     "; serve the object as this user, or write " + name + " = \"" + who->user +
                     "@" + who->host + "\" in that table"};
}

NameDecision may_report(const LabAccess& lab, const std::string& zone, const std::string& source,
                        const Reporter& reporter) {
  const std::string what = source + " of " + zone;
  const std::string who =
      "a program of " + (reporter.who ? words(*reporter.who) : std::string("an unknown user"));
  const auto owners = lab.sources.find(zone);
  const auto bound =
      owners == lab.sources.end() ? SourceOwners::const_iterator() : owners->second.find(source);
  if (owners == lab.sources.end() || bound == owners->second.end()) {
    const std::string rule = "no [objects." + zone + ".sources] of a lab file binds this source";
    if (reporter.own) return {true, who + " may report for " + what + ": " + rule};
    const std::string owner = reporter.who ? reporter.who->user + "@" + reporter.who->host : "…";
    return {false, who + " may not report for " + what + ": " + rule +
                       ", so only the user of the zone's server may report for it; write " +
                       source + " = \"" + owner + "\" under [objects." + zone + ".sources]"};
  }
  const auto& [owner, place] = bound->second;
  if (reporter.who == owner) {
    return {true, who + " may report for " + what + ": " + place + " names this user"};
  }
  return {false, who + " may not report for " + what + ": " + place + " binds this source to " +
                     words(owner) + "; report as this user, or name another user in that table"};
}

AccessRule decide_by(const AllowList& list, const UserAtHost& server, const UserAtHost& who) {
  if (const auto rule = admitted_without_list(server, who)) return *rule;
  return refusal_of(list, server, who).value_or(AccessRule::Named);
}

AllowList whom_both_admit(const AllowList& one, const AllowList& other) {
  return {names_in_both(one.users, other.users), names_in_both(one.hosts, other.hosts),
          one.place + " and " + other.place};
}

AccessDecision AccessPolicy::decide(const UserAtHost& server, const UserAtHost& who,
                                    std::string_view object) const {
  if (const auto rule = admitted_without_list(server, who)) {
    return admit(*rule, who, object,
                 *rule == AccessRule::OwnUser
                     ? "the server of the object runs as this user of this host"
                     : "root may do everything on its own host");
  }
  if (insecure) {
    return admit(
        AccessRule::Insecure, who, object,
        "the server of the object was started with --insecure, so no list of users counts");
  }
  const AllowList* const in_file = list_of(lab, server, who, object);
  const AllowList* const in_program = program ? &*program : nullptr;
  std::string admitting;
  for (const AllowList* const list : {in_program, in_file}) {
    if (list == nullptr) continue;
    if (const auto rule = decide_by(*list, server, who); rule != AccessRule::Named) {
      return refuse(rule, *list, who, object);
    }
    admitting += (admitting.empty() ? "" : " and ") + list->place;
  }
  if (admitting.empty()) return nobody_named(lab, server, who, object);
  return admit(AccessRule::Named, who, object, "named by " + admitting);
}

AllowList AccessPolicy::named_by_program(std::string_view object) const {
  if (!program) return {};
  const AllowList* const in_file = insecure ? nullptr : list_of(lab, object);
  return in_file == nullptr ? *program : whom_both_admit(*program, *in_file);
}

bool AccessPolicy::administers(const UserAtHost& server, const UserAtHost& who) const {
  return who == server || (lab.admin && !refusal_of(*lab.admin, server, who));
}

}  // namespace gecos::access
