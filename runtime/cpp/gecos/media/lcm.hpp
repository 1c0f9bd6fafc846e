#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "gecos/media/medium.hpp"

/// UDP multicast through LCM, for programs of several hosts.
///
/// Each object's calls have a UDP port of their own, and so have the answers to each client, because
/// the kernel wakes everybody who listens on a port, whatever group or channel was meant. A stream
/// goes out once for all its readers. Packets may be lost, repeated and overtake each other, and
/// nobody's name is proved: what makes a line of it, and a safe one, is above.
namespace gecos::media {

struct LcmOptions {
  std::string group = "239.255.76.67";
  std::uint16_t well_known_port = 7668;  ///< next to LCM's own 7667, so that calls wake no lcm-spy
  /// How many routers a packet may pass. 0: it stays on this host.
  int ttl = 0;
  /// Asked of the kernel for each socket that receives; net.core.rmem_max may give less.
  int receive_buffer_bytes = 2 * 1024 * 1024;
};

/// The largest packet. With our header it stays in one datagram of LCM, since those that LCM cuts
/// come out wrong when one piece is repeated. Between hosts it still is some 42 pieces of Ethernet, of
/// which none may be lost: large things belong on shm.
inline constexpr std::size_t largest_lcm_packet = 60 * 1024;

std::unique_ptr<Medium> make_lcm(LcmOptions options = {});

}  // namespace gecos::media
