#pragma once

#include <cstdint>
#include <map>
#include <optional>
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

/// Whom the program of one server admits to its objects, as the server told the broker.
struct ProgramList {
  UserAtHost server;         ///< as the registration says
  std::uint64_t boot = 0;    ///< the life of the server
  std::uint64_t number = 0;  ///< of this list; a later list of the same life has a greater number
  AllowList list;
};

/// Returns whether `one` makes `who` a visitor: the list names `who`, by the rule by which the
/// server itself decides. The user of the server and root need no list, and so are no visitors.
bool admits_visitor(const ProgramList& one, const UserAtHost& who);

/// The lists of the objects that the broker knows, and the users whom the user of the broker has
/// revoked. A list stays while the server of the object is silent. Thread-safe.
class VisitorBook {
 public:
  /// Sets the list of the object `name`, whose server lives as `boot`. The call has no effect if
  /// the book has a list of the same life with the same or a greater number. Without a list, the
  /// call drops the list of another life. Returns whether the book has changed.
  bool set(const std::string& name, std::uint64_t boot, std::optional<ProgramList> list);
  /// Drops the lists of the objects that are not known.
  void keep_only(FunctionRef<bool(const std::string& name)> known);
  bool empty() const;

  /// Returns an object whose list makes `who` a visitor; no value if there is none.
  std::optional<std::string> object_of(const UserAtHost& who) const;
  /// Returns whether the list of the object `name` makes `who` a visitor.
  bool shows(const std::string& name, const UserAtHost& who) const;
  /// Returns a number that stands for the lists of the objects that `who` sees. Two sets of lists
  /// have different numbers; a list that is set again counts as another list.
  std::uint64_t view_of(const UserAtHost& who) const;

  /// Sets the list of the revoked users. No value means that the list is not known at the moment;
  /// the last known list then counts.
  /// A book without lists forgets whether it is known.
  void revoke(std::optional<std::vector<RevokedUser>> revoked);
  bool knows_revoked() const;
  /// Returns whether a client is revoked; see access::revokes.
  bool revoked(std::string_view key, const UserAtHost& who) const;

 private:
  struct Listed {
    ProgramList program;
    std::uint64_t change = 0;  ///< the number of the change that set it
  };

  mutable Mutex mutex_;
  std::map<std::string, Listed> lists_ GECOS_GUARDED_BY(mutex_);  ///< by the name of the object
  std::uint64_t changes_ GECOS_GUARDED_BY(mutex_) = 0;
  std::vector<RevokedUser> revoked_ GECOS_GUARDED_BY(mutex_);
  bool knows_revoked_ GECOS_GUARDED_BY(mutex_) = false;
};

}  // namespace gecos::access
