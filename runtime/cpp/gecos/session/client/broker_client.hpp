#pragma once

#include <string>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/context.hpp"

/// The few broker calls that sessions need. Sessions must not use the broker's generated client,
/// which is built on sessions.
namespace gecos::session {

inline constexpr std::string_view broker_name = "BROKER";

/// Looks up the object `name`. Fails with a text: "no object is called RX91; known are LASER,
/// RX90".
tl::expected<Entry, std::string> look_up(Context& lab, const std::string& name, TimePoint deadline);

/// Asks the broker to make an object findable until the session with it ends. `served_for`: how
/// long the object has been served.
std::shared_ptr<CommandCore> register_object(ClientConnection& broker, const Entry& entry,
                                             Duration served_for);

struct NotRegistered {
  bool taken = false;    ///< another object has the name; retry only after that one is gone
  std::string by;        ///< that object
  bool unheard = false;  ///< the broker is gone or ends; the next one may be asked
  std::string text;
};
/// Waits for the result of `register_object`: how long the broker, which has just started, may
/// still assign the name to an object that has been served for longer. 0: the name is settled.
tl::expected<Duration, NotRegistered> await_registered(CommandCore& asked, TimePoint deadline);
void unregister_object(ClientConnection& broker, const std::string& name);

}  // namespace gecos::session
