#pragma once

#include <string>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/lab_core.hpp"

/// The broker as sessions see it. What they need of it is small, and they may not use its generated
/// client, which stands on them.
namespace gecos::session {

inline constexpr std::string_view broker_name = "BROKER";
const InterfaceDescription& broker_interface();

/// Where `name` is, or why that is not known: "no object is called RX91; known are LASER, RX90".
tl::expected<Entry, std::string> look_up(LabCore& lab, const std::string& name, TimePoint deadline);

/// Makes an object findable until the session with this broker ends.
struct NotEnlisted {
  bool taken = false;  ///< another object has that name: trying again helps only when that one goes
  bool unheard = false;  ///< it certainly did not reach the broker, which is gone
  std::string text;
};
tl::expected<void, NotEnlisted> enlist(LinkedSession& broker, const Entry& entry,
                                       TimePoint deadline);
void withdraw(LinkedSession& broker, const std::string& name);

}  // namespace gecos::session
