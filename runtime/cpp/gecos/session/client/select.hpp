#pragma once

#include <string>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/description.hpp"
#include "gecos/explanation.hpp"
#include "gecos/qos/match.hpp"
#include "gecos/qos/requested_quality.hpp"
#include "gecos/session/client/lab_file_settings.hpp"
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

/// Returns what a session over a medium with these capabilities promises. `stated`: what the lab
/// file states about the media. If the file cannot be used, no medium is real-time, because the
/// file might say so.
qos::LineCapabilities line_of(const media::Capabilities& capabilities,
                              const StatedMedia& stated = {});

/// Returns the quality that a medium must have because of `asked` and of `requested`, the request
/// of the program. For a simulated device, soft real time is enough and the latency is not bounded,
/// because a late packet does no harm there; the request applies in full.
qos::Quality demanded_of(qos::Quality asked, bool simulated,
                         const qos::RequestedQuality& requested = {});

/// Returns the smallest latency that `wanted` or one of its members demands with a real-time class,
/// which the interface declares or the program requests; zero when no latency is demanded.
Duration smallest_latency(const InterfaceDescription& wanted,
                          const qos::RequestedQuality& requested = {});

/// Returns whether `wanted` or one of its members, or the request of the program, demands
/// HARD_REALTIME of the medium. Of a simulated device, only the request can demand it.
bool demands_hard_real_time(const InterfaceDescription& wanted, bool simulated,
                            const qos::RequestedQuality& requested = {});

/// Returns the name of the medium of an address: "shm".
std::string medium_of(const std::string& address);

/// Returns what a session would promise at `address`, one of the addresses of `entry`. If this
/// program cannot reach the object there, returns the reason.
tl::expected<qos::LineCapabilities, std::string> line_to(Runtime& runtime, const Entry& entry,
                                                         const std::string& address,
                                                         const StatedMedia& stated);

/// Returns the operations and streams of `interface` that `line` does not suit: it does not meet
/// the quality that they declare or the quality that is `requested`. `simulated`: whether the
/// object is a simulated device.
std::vector<UnsuitedMember> unsuited_members(const InterfaceDescription& interface,
                                             const qos::LineCapabilities& line, bool simulated,
                                             const qos::RequestedQuality& requested = {});

/// A medium that may lead to an object: an address of the object, and the quality that a session
/// over this address has.
struct Route {
  std::string address;
  qos::LineCapabilities line;
};

/// Decides which medium a client uses for the object `entry`. No other code makes this decision.
/// Reads no clock and sends nothing.
class Selection {
 public:
  /// `demanded`: what the medium must meet. `stated`: what the lab file states about the media.
  /// `only`: the only medium to consider. `without`: a medium not to consider, because a session
  /// over it became too slow.
  Selection(Runtime& runtime, const Entry& entry, const qos::Quality& demanded,
            const StatedMedia& stated, std::optional<media::Kind> only,
            std::optional<media::Kind> without = {});

  /// Returns the routes that meet the demanded quality, best first.
  std::vector<Route> best_first() const;
  /// Must be called when the latency of `route` was measured. Returns whether the route still meets
  /// the demanded quality.
  bool measured(const Route& route);
  /// Must be called when no session could be opened over `route`.
  void not_reached(const Route& route, const std::string& why);
  /// Returns the media that can reach another process but are no routes to the object, each with
  /// the reason, for example "shm: the object is on another host (desk)".
  const std::string& left_out() const { return left_out_; }
  /// Returns why no route is suitable: each medium with the terms that it violates.
  std::string why_none() const;

 private:
  void pass_over(const std::string& address, const std::string& why);

  const qos::Quality demanded_;
  const std::string asked_for_;  ///< for messages: " over lcm" when only lcm is considered
  const std::string offered_;    ///< the media that the server offers, "inproc, shm"
  std::vector<Route> routes_;    ///< the routes that this program can reach
  std::string passed_over_;      ///< the other media, each with the reason
  std::string left_out_;         ///< see left_out()
};

}  // namespace gecos::session
