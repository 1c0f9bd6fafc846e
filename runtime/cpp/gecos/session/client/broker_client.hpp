#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/context.hpp"

/// The few broker calls that sessions need. Sessions must not use the broker's generated client,
/// which is built on sessions.
namespace gecos::session {

inline constexpr std::string_view broker_name = "BROKER";

/// Looks up the object `name`. On failure returns a text such as "no object is called RX91; start
/// the object's server, or choose a name that the broker knows: LASER, RX90". If the broker no
/// longer hears the server of the object, the text says for how long.
tl::expected<Entry, std::string> look_up(Context& lab, const std::string& name, TimePoint deadline);

/// Returns the object `name` if its server is silent. Returns nullopt when its server is online,
/// when the broker does not know the object, and when the broker does not answer.
std::optional<SilentObject> look_up_silent(Context& lab, const std::string& name,
                                           TimePoint deadline);

/// Returns the objects online whose interface is `interface_name` or is derived from it. If
/// `interface_name` is empty, returns all objects online. On failure returns why the broker gave no
/// answer.
tl::expected<std::vector<Entry>, std::string> query(Context& lab, const std::string& interface_name,
                                                    TimePoint deadline);
/// Returns the changes of the broker's list after the revision `since`. If the broker is of an
/// older version, the result is always the broker's whole list, without the silent objects.
tl::expected<ListChanges, std::string> list_changes(Context& lab, const ListRevision& since,
                                                    TimePoint deadline);

/// Returns for how long `broker` has been running; nullopt if it does not answer by `deadline`, or
/// is of a version that does not say this.
std::optional<Duration> running_for(ClientConnection& broker, TimePoint deadline);

/// Registers the object `entry` with the broker until the session with the broker ends.
/// `served_for`: how long the object has been served. `admitted`: the users and hosts that the
/// program of the server admits; no value if the program admits no other users. `confirmed_ago`:
/// how long ago this server last asked for the name and got a final answer; no value if it never
/// did.
std::shared_ptr<CommandCore> register_object(ClientConnection& broker, const Entry& entry,
                                             Duration served_for,
                                             const std::optional<AdmittedNames>& admitted = {},
                                             std::optional<Duration> confirmed_ago = {});

struct NotRegistered {
  bool taken = false;    ///< another object has the name; retry only after that object is gone
  std::string by;        ///< describes the object that has the name
  bool unheard = false;  ///< the broker is gone or shuts down; retry with the next broker
  std::string text;
};
/// Waits for the result of `register_object`. Returns how long the registration is provisional: a
/// broker that has just started may still assign the name to another object with a better claim.
/// 0: the registration is final.
tl::expected<Duration, NotRegistered> await_registered(CommandCore& asked, TimePoint deadline);
void unregister_object(ClientConnection& broker, const std::string& name);

}  // namespace gecos::session
