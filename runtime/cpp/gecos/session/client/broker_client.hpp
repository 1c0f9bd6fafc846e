#pragma once

#include <string>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/context.hpp"

/// The broker as sessions see it. What they need of it is small, and they may not use its generated
/// client, which stands on them.
namespace gecos::session {

inline constexpr std::string_view broker_name = "BROKER";

/// Where `name` is, or why that is not known: "no object is called RX91; known are LASER, RX90".
tl::expected<Entry, std::string> look_up(Context& lab, const std::string& name, TimePoint deadline);

/// Asks the broker to make an object findable until the session with it ends. `served_for`: how
/// long the object has been served.
std::shared_ptr<CommandCore> register_object(ClientConnection& broker, const Entry& entry,
                                             Duration served_for);

struct NotRegistered {
  bool taken = false;  ///< another object has that name: trying again helps only when that one goes
  std::string by;      ///< that object
  bool unheard = false;  ///< the broker is gone or ends; the next one may be asked
  std::string text;
};
/// What came of it: how long the broker, which has just started, may still give the name to an
/// object that has been served for longer. 0: the name is settled.
tl::expected<Duration, NotRegistered> await_registered(CommandCore& asked, TimePoint deadline);
void unregister_object(ClientConnection& broker, const std::string& name);

}  // namespace gecos::session
