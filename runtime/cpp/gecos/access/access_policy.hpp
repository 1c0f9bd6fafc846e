#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Decides which clients may connect to an object, by user and host. What a client may do once it
/// is connected depends on its status (lease_table.hpp), not on these decisions.
namespace gecos::access {

/// The object name of the broker. Programs find the broker by its address, not by a registration of
/// this name.
inline constexpr std::string_view broker_object = "BROKER";

/// A user on a host. The medium proves both names: for a program of this host, the kernel names the
/// user; otherwise a key proves the user and the host.
struct UserAtHost {
  std::string user;  ///< the name, or "uid 1234" of a user without a name
  std::string host;
  friend bool operator==(const UserAtHost&, const UserAtHost&) = default;
};

/// The entry of an AllowList that stands for every name. A list with this entry has no other entry.
inline constexpr std::string_view everyone = "*";

/// The longest name of a user or of a host in a list, and of an object, in bytes.
inline constexpr std::size_t longest_name = 256;

/// Returns why a user, a host or an object cannot have the name `name`, for example "is empty"; an
/// empty text if the name is valid. The text continues a sentence that begins with "a name".
/// @pre `name` is UTF-8
std::string_view fault_of_name(std::string_view name);

/// The users and hosts that may connect to a server, in addition to the user and the host of the
/// server itself. A client is admitted if its user is in `users` or is the user of the server, and
/// its host is in `hosts` or is the host of the server.
struct AllowList {
  std::vector<std::string> users;
  std::vector<std::string> hosts;
  std::string place;  ///< for messages, for example "[allow] in /etc/gecos/lab.toml:3"
};

/// The only user who may register an object under a name, or report for a source of a zone.
struct NameOwner {
  UserAtHost owner;
  std::string place;  ///< for messages, for example "[names] in /etc/gecos/lab.toml:3"
};

/// The owners of the sources of one zone, by the name of the source.
using SourceOwners = std::map<std::string, NameOwner>;

/// The rules of a lab file: which users may connect to objects, which users may serve objects, in
/// which zone an object is, and whether samples may be sent in clear.
struct LabAccess {
  std::string file;                    ///< path, for messages; "" if there is no lab file
  std::optional<AllowList> general{};  ///< the list for the objects that have no list of their own
  /// The lists of the objects that have a list of their own, by the name of the object.
  std::map<std::string, AllowList> objects{};
  std::optional<AllowList> admin{};            ///< who may end the status of other users
  std::map<std::string, NameOwner> names{};    ///< the owner of each bound name, by this name
  std::map<std::string, std::string> zones{};  ///< the zone of each object that is in one
  /// The owners of the sources of each zone, by the name of the zone.
  std::map<std::string, SourceOwners> sources{};
  /// The place where the file forbids sending the samples of an @open_stream in clear, for
  /// messages, for example "[streams] in /etc/gecos/lab.toml:3"; "" if the file does not forbid
  /// this.
  std::string forbids_open_streams{};
};

enum class AccessRule {
  OwnUser,      ///< admitted: the user of the server, on its host
  Root,         ///< admitted: root of the server's host, who could read the memory of the server
  Named,        ///< admitted: every list that holds for the object admits the user and the host
  Insecure,     ///< admitted: the server admits every user and host (AccessPolicy::insecure)
  NobodyNamed,  ///< refused: no list holds for the object
  UserNotNamed,
  HostNotNamed,
};

struct NameDecision {
  bool allowed = true;
  std::string text;  ///< a sentence for people, in the form of AccessDecision::text
};

struct AccessDecision {
  AccessRule rule;
  std::string text;  ///< a sentence that names the object, user, host and rule; a refusal also says
                     ///< what to change where
  bool allowed() const { return rule <= AccessRule::Insecure; }
};

/// Decides whether a server of `who` may register an object under `name`. If the lab file binds the
/// name, only its owner may register it; root and the user of the broker may not. Any server may
/// register any other name.
/// @param who no value if nothing proves the user and the host of the server
NameDecision may_register(const LabAccess& lab, const std::string& name,
                          const std::optional<UserAtHost>& who);

/// A program that wants to report for a source of a zone, such as a door.
struct Reporter {
  /// The user and the host of the program; no value if nothing proves them.
  std::optional<UserAtHost> who{};
  bool own = false;  ///< the user of the zone's server, or root on its host, runs the program
};

/// Decides whether `reporter` may report for `source` of `zone`. If the lab file binds the source,
/// only its owner may. Otherwise only programs of the user of the zone's server, or of root on its
/// host, may report. Permission to connect to the zone is not enough, because a report can make a
/// person present.
NameDecision may_report(const LabAccess& lab, const std::string& zone, const std::string& source,
                        const Reporter& reporter);

/// Returns the rule by which `list` alone admits or refuses `who`: OwnUser, Root, Named,
/// UserNotNamed or HostNotNamed. `server`: the user and host of the server.
AccessRule decide_by(const AllowList& list, const UserAtHost& server, const UserAtHost& who);

/// Returns the list that, by the rule of `decide_by`, admits exactly the users whom `one` and
/// `other` both admit.
AllowList whom_both_admit(const AllowList& one, const AllowList& other);

/// Decides who may connect to the objects of one server. The user of the server and root may always
/// connect on the server's host. Two lists can name other users: the list that the program gave to
/// `Server::allow`, and the list of the lab file for the object. Another user may connect if at
/// least one of the two lists exists and each existing list admits the user.
///
/// Everyone whom any list of the lab file admits to an object may also connect to the broker,
/// unless the file has a list for the broker itself.
struct AccessPolicy {
  std::optional<AllowList> program{};  ///< the list that was given to `Server::allow`
  LabAccess lab{};
  /// If true, every user on every host may connect: the list of the program and the list of the lab
  /// file do not count. The administrators, the names, the zones and the sources of zones in the
  /// lab file still count.
  bool insecure = false;

  AccessDecision decide(const UserAtHost& server, const UserAtHost& who,
                        std::string_view object) const;
  /// Returns the list of the program without the users and hosts that the list of the lab file for
  /// `object` does not name. If the program has no list, returns a list that names nobody.
  /// @pre `object` is not the broker
  AllowList named_by_program(std::string_view object) const;
  /// Returns whether `who` may end the status of other users. The user of the server may do so on
  /// the server's host, and the users in [admin] of the lab file may do so.
  bool administers(const UserAtHost& server, const UserAtHost& who) const;
};

}  // namespace gecos::access
