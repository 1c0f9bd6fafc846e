#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "gecos/base/clock.hpp"
#include "gecos/crypto/transport.hpp"
#include "gecos/media/medium.hpp"

/// The medium lcm: UDP multicast through the library LCM, for programs on several hosts.
///
/// Each object receives calls on a UDP port of its own. Each program receives answers on up to
/// eight UDP ports of its own, which its connections share. The reason is that the kernel wakes
/// every process that listens on a port, whatever the multicast group or LCM channel of the
/// datagram. Each sample of a stream is sent once for all readers. All packets are sealed
/// (gecos/media/sealed); the code in this folder only sends and receives datagrams. Packets may be
/// lost and reordered; the session puts them in order.
namespace gecos::media {

struct LcmOptions {
  std::string group = "239.255.76.67";
  std::uint16_t well_known_port = 7668;  ///< not LCM's 7667, so that calls do not wake lcm-spy
  std::uint16_t open_port = 7667;        ///< of open streams: the port at which LCM's tools listen
  /// The number of routers that a packet may pass. With 0, packets stay on this host.
  int ttl = 0;
  /// The size of the receive buffer that each socket requests. The kernel setting net.core.rmem_max
  /// may limit this size.
  int receive_buffer_bytes = 2 * 1024 * 1024;
  /// The path of the key directory, which is opened on first use. If the path is empty,
  /// crypto::KeyDirectory::default_path() is used.
  std::string key_directory;
  crypto::RekeyRule rekey;
  /// The clock for repeated sending and for changes of the keys. If null, the system's clock is
  /// used. The clock must outlive the medium and its connections.
  const Clock* clock = nullptr;
};

/// The size of the largest packet in bytes. With its seal and all headers, such a packet fits in
/// one LCM datagram. This is necessary because LCM reassembles a fragmented message wrongly when a
/// fragment is repeated. Between hosts, such a packet takes about 42 Ethernet frames, and the
/// packet is lost if one of them is lost. Use shm for large data.
inline constexpr std::size_t largest_lcm_packet = 60 * 1024;

/// A packet that is larger than this number of bytes is sent in pieces of this size. Only lost
/// pieces are sent again.
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
