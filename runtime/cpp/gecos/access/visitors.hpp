#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/access/access_policy.hpp"
#include "gecos/access/revocations.hpp"
#include "gecos/base/function_ref.hpp"
#include "gecos/base/mutex.hpp"

/// Visitors of the broker: users whom no list of the lab file admits to the broker, but whom the
/// program of a server admits to its objects. A visitor finds these objects, and may do nothing
/// else at the broker.
namespace gecos::access {

/// The maximum number of users, and of hosts, that a program may name.
inline constexpr std::size_t most_admitted_names = 256;

/// Identifies one run of a server process. The broker takes these facts from the medium, not from
/// what the server says.
struct ServerLife {
  UserAtHost user;
  std::uint64_t boot = 0;  ///< differs after each restart of the server
  bool own = false;        ///< the user of the broker, or root, runs the server
  std::string key{};       ///< the key that `user` has proved; empty if the kernel names the user
  friend bool operator==(const ServerLife&, const ServerLife&) = default;
};

/// The users and hosts that the program of one server admits to its objects, as the server told the
/// broker.
struct ProgramList {
  ServerLife server;
  /// The number of this list; a later list of the same server process has a greater number.
  std::uint64_t number = 0;
  AllowList list;
};

/// Returns whether the list in `one` names `who`, which makes `who` a visitor. The server itself
/// decides by the same rule. The user of the server and root need no list, so they are no visitors.
bool admits_visitor(const ProgramList& one, const UserAtHost& who);

/// The broker's record of its visitors: the list of users and hosts for each object, and the users
/// whom the broker's user has revoked. The list of an object stays as long as the object keeps its
/// name, even while its server is silent. The list of a revoked user makes nobody a visitor.
/// Thread-safe.
class VisitorBook {
 public:
  /// Sets the list of the object `name`. Does nothing if the VisitorBook has a list of the same run
  /// of the server with the same or a greater number. `revision`: the number of the broker's last
  /// change. Returns whether the VisitorBook has changed.
  bool set(const std::string& name, ProgramList list, std::uint64_t revision);
  /// Must be called when `server` has registered `name` without a list. Drops the list of `name` if
  /// another server, or another run of this server, has set the list. Returns whether the
  /// VisitorBook has changed.
  bool drop_other(const std::string& name, const ServerLife& server);
  /// Drops the visitor list of each object for whose name `keeps_name` returns false. Returns
  /// whether a list was dropped.
  bool keep_only(FunctionRef<bool(const std::string& name)> keeps_name);
  /// Returns whether at least one of the lists names a user or a host.
  bool names_somebody() const;

  /// Returns an object whose list makes `who` a visitor; no value if there is none. Ignores the
  /// lists of servers for which `counts` returns false.
  std::optional<std::string> object_of(const UserAtHost& who,
                                       FunctionRef<bool(const ServerLife& server)> counts) const;
  /// The objects that one user sees as a visitor.
  struct Seen {
    std::set<std::string> objects{};  ///< their names
    /// A hash that identifies the lists of these objects. Different sets of lists have different
    /// hashes, except for collisions. A list that is set again counts as a different list.
    std::uint64_t view = 0;
    /// The number of the broker's last change at the time when the newest of the lists was set.
    /// Earlier changes may concern servers whose lists did not name the user.
    std::uint64_t since = 0;
  };
  Seen seen_by(const UserAtHost& who) const;

  /// Sets the list of the revoked users.
  void set_revoked(std::vector<RevokedUser> revoked);
  /// Must be called when the list of the revoked users cannot be read at present. The last list
  /// that was set still counts.
  void lose_revoked();
  /// Returns whether the list of the revoked users is known. It is not known at first, after
  /// lose_revoked(), and after the last list that names somebody has gone.
  bool knows_revoked() const;
  /// Returns whether a client is revoked; see access::revokes.
  bool revoked(std::string_view key, const UserAtHost& who) const;

 private:
  struct Listed {
    ProgramList program;
    std::uint64_t change = 0;    ///< the number of the change of this VisitorBook that set the list
    std::uint64_t revision = 0;  ///< the number of the broker's last change when the list was set
  };
  bool admits(const ProgramList& one, const UserAtHost& who) const GECOS_REQUIRES(mutex_);
  bool names_somebody_now() const GECOS_REQUIRES(mutex_);
  /// If no list names anybody any more, records that the revoked users are not known, because
  /// nobody then reads the list of the revoked users.
  void forget_revoked_if_unused() GECOS_REQUIRES(mutex_);

  mutable Mutex mutex_;
  /// For each object, by its name: the list of the users and hosts that its program admits.
  std::map<std::string, Listed> lists_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t changes_ GECOS_GUARDED_BY(mutex_) = 0;
  std::vector<RevokedUser> revoked_ GECOS_GUARDED_BY(mutex_);
  bool knows_revoked_ GECOS_GUARDED_BY(mutex_) = false;
};

}  // namespace gecos::access
