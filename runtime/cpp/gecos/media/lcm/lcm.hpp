#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "gecos/base/clock.hpp"
#include "gecos/crypto/transport.hpp"
#include "gecos/media/medium.hpp"

/// UDP multicast through LCM, for programs of several hosts.
///
/// Each object has its own UDP port for calls, and each client has its own UDP port for answers.
/// The reason: the kernel wakes every process that listens on a port, whatever the group or
/// channel. Each sample of a stream is sent once for all readers. All packets are sealed
/// (gecos/media/sealed); this folder only sends and receives datagrams. Packets may be lost and
/// reordered; the session puts them in order.
namespace gecos::media {

struct LcmOptions {
  std::string group = "239.255.76.67";
  std::uint16_t well_known_port = 7668;  ///< not LCM's 7667, so that calls do not wake lcm-spy
  /// How many routers a packet may pass. 0: packets stay on this host.
  int ttl = 0;
  /// Requested receive buffer of each socket; net.core.rmem_max may limit it.
  int receive_buffer_bytes = 2 * 1024 * 1024;
  /// Directory of the keys; empty: crypto::KeyDirectory::default_path(). Opened on first use.
  std::string key_directory;
  crypto::RekeyRule rekey;
  /// The clock for retries and rekeying; null: the system's. Must outlive the medium and its
  /// connections.
  const Clock* clock = nullptr;
};

/// Bytes of the largest packet. Sealed and with all headers, it fits in one LCM datagram, because
/// LCM reassembles fragmented messages wrongly when a fragment is repeated. Between hosts it still
/// takes about 42 Ethernet frames, none of which may be lost: use shm for large data.
inline constexpr std::size_t largest_lcm_packet = 60 * 1024;

/// Larger packets are sent in pieces of this many bytes; only lost pieces are sent again.
inline constexpr std::size_t largest_lcm_piece = 8 * 1024;

inline constexpr Capabilities lcm_capabilities{.name = "lcm",
                                               .reach = Reach::Network,
                                               .ordered = false,
                                               .reliable = false,
                                               .real_time = false,
                                               .reports_death = false,
                                               .authenticated = true,
                                               .overheard = true,
                                               .connectionless = true,
                                               .largest_packet = largest_lcm_packet,
                                               .piece = largest_lcm_piece};

std::unique_ptr<Medium> make_lcm(LcmOptions options = {});

}  // namespace gecos::media
