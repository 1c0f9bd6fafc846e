#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "gecos/base/clock.hpp"
#include "gecos/crypto/transport.hpp"
#include "gecos/media/medium.hpp"

/// UDP multicast through LCM, for programs of several hosts.
///
/// Each object's calls have a UDP port of their own, and so have the answers to each client,
/// because the kernel wakes everybody who listens on a port, whatever group or channel was meant. A
/// stream goes out once for all its readers. Everything is sealed (gecos/media/sealed): this folder
/// only carries datagrams. Packets may be lost and reordered; the session makes a line of them.
namespace gecos::media {

struct LcmOptions {
  std::string group = "239.255.76.67";
  std::uint16_t well_known_port = 7668;  ///< next to LCM's own 7667, so that calls wake no lcm-spy
  /// How many routers a packet may pass. 0: it stays on this host.
  int ttl = 0;
  /// Asked of the kernel for each socket that receives; net.core.rmem_max may give less.
  int receive_buffer_bytes = 2 * 1024 * 1024;
  /// Where the keys are; empty: crypto::KeyDirectory::default_path(). Opened with the first use.
  std::string key_directory;
  crypto::RekeyRule rekey;
  /// For retries and rekeying; null: the system's. Must outlive the medium and its links.
  const Clock* clock = nullptr;
};

/// The largest packet. Sealed, with our headers, it stays in one datagram of LCM, since those that
/// LCM cuts come out wrong when one piece is repeated. Between hosts it still is some 42 pieces of
/// Ethernet, of which none may be lost: large things belong on shm.
inline constexpr std::size_t largest_lcm_packet = 60 * 1024;

/// A packet above this travels in pieces, of which only the lost ones are sent again.
inline constexpr std::size_t largest_lcm_piece = 8 * 1024;

inline constexpr Offer lcm_offer{.name = "lcm",
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
