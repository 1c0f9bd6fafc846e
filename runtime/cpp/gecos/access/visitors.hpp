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

/// The most users, and the most hosts, that a program may name.
inline constexpr std::size_t most_admitted_names = 256;

/// One life of a server, as the medium proves it to the broker.
struct ServerLife {
  UserAtHost user;
  std::uint64_t boot = 0;  ///< differs after each restart of the server
  bool own = false;        ///< the server is of the user of the broker, or of root
  std::string key{};       ///< that `user` has proved; empty if the kernel names the user
  friend bool operator==(const ServerLife&, const ServerLife&) = default;
};

/// Whom the program of one server admits to its objects, as the server told the broker.
struct ProgramList {
  ServerLife server;
  std::uint64_t number = 0;  ///< of this list; a later list of the same life has a greater number
  AllowList list;
};

/// Returns whether `one` makes `who` a visitor: the list names `who`, by the rule by which the
/// server itself decides. The user of the server and root need no list, and so are no visitors.
bool admits_visitor(const ProgramList& one, const UserAtHost& who);

/// The lists of the objects that the broker knows, and the users whom the user of the broker has
/// revoked. A list stays while the server of the object is silent and keeps the name. The list of a
/// revoked user makes nobody a visitor. Thread-safe.
class VisitorBook {
 public:
  /// Sets the list of the object `name`. The call has no effect if the book has a list of the same
  /// life of the server with the same or a greater number. `revision`: the number of the broker's
  /// last change. Returns whether the book has changed.
  bool set(const std::string& name, ProgramList list, std::uint64_t revision);
  /// `server` has registered `name` without a list. Drops the list of `name` if it is of another
  /// life or of another server. Returns whether the book has changed.
  bool drop_other(const std::string& name, const ServerLife& server);
  /// Drops the lists of the objects that do not keep their names. Returns whether there were some.
  bool keep_only(FunctionRef<bool(const std::string& name)> keeps_name);
  /// Returns whether a list names a user or a host.
  bool names_somebody() const;

  /// Returns an object whose list makes `who` a visitor; no value if there is none. Skips the lists
  /// of the servers to which `counts` does not apply.
  std::optional<std::string> object_of(const UserAtHost& who,
                                       FunctionRef<bool(const ServerLife& server)> counts) const;
  /// What one user sees as a visitor.
  struct Seen {
    std::set<std::string> objects{};  ///< their names
    /// A number that stands for the lists of these objects. Two sets of lists have different
    /// numbers, but for a collision of the hash; a list that is set again counts as another list.
    std::uint64_t view = 0;
    /// The broker's last change when the newest of the lists was set. Earlier changes may be of
    /// servers whose lists did not name the user.
    std::uint64_t since = 0;
  };
  Seen seen_by(const UserAtHost& who) const;

  /// Sets the list of the revoked users.
  void set_revoked(std::vector<RevokedUser> revoked);
  /// The revoked users are not known at the moment. The last list that was set still counts.
  void lose_revoked();
  /// False at first, after lose_revoked(), and when the last list that names somebody has gone.
  bool knows_revoked() const;
  /// Returns whether a client is revoked; see access::revokes.
  bool revoked(std::string_view key, const UserAtHost& who) const;

 private:
  struct Listed {
    ProgramList program;
    std::uint64_t change = 0;    ///< the number of the change of the book that set it
    std::uint64_t revision = 0;  ///< the broker's last change at that moment
  };
  bool admits(const ProgramList& one, const UserAtHost& who) const GECOS_REQUIRES(mutex_);
  bool names_somebody_now() const GECOS_REQUIRES(mutex_);
  /// While no list names anybody, nobody reads the list of the revoked users.
  void forget_revoked_if_unused() GECOS_REQUIRES(mutex_);

  mutable Mutex mutex_;
  std::map<std::string, Listed> lists_ GECOS_GUARDED_BY(mutex_);  ///< by the name of the object
  std::uint64_t changes_ GECOS_GUARDED_BY(mutex_) = 0;
  std::vector<RevokedUser> revoked_ GECOS_GUARDED_BY(mutex_);
  bool knows_revoked_ GECOS_GUARDED_BY(mutex_) = false;
};

}  // namespace gecos::access
