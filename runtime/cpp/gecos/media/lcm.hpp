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
/// stream goes out once for all its readers. Nothing is in clear but who sends to whom: both ends
/// prove their keys to each other, each has to have admitted the other's
/// (gecos/crypto/key_directory.hpp), and what was altered, forged or played back never arrives.
/// Packets may be lost and overtake each other: what makes a line of it is above.
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

  /// By CLOCK_BOOTTIME: what lay in a socket while the machine was suspended is as old as that.
  TimePoint now() const {
    return clock != nullptr ? clock->since_boot() : SystemClock().since_boot();
  }
  /// The same as it travels in packets.
  std::int64_t now_ns() const { return now().time_since_epoch().count(); }
};

/// The largest packet. Sealed, with our headers, it stays in one datagram of LCM, since those that
/// LCM cuts come out wrong when one piece is repeated. Between hosts it still is some 42 pieces of
/// Ethernet, of which none may be lost: large things belong on shm.
inline constexpr std::size_t largest_lcm_packet = 60 * 1024;

std::unique_ptr<Medium> make_lcm(LcmOptions options = {});

}  // namespace gecos::media
