#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/crypto/transport.hpp"
#include "gecos/media/medium.hpp"

/// The interface between a medium that others can overhear and the code that seals it.
///
/// A medium provides ports that send and receive datagrams. Datagrams may be lost, repeated and
/// reordered; anybody may overhear datagrams and send forged ones. This folder implements the rest
/// once for all such media: proving keys, sealing, connections, streams. docs/protocol.md is
/// normative for the bytes.
namespace gecos::media {

/// One numbered port: sends to and receives from its channels.
class DatagramPort {
 public:
  using Take = std::function<void(ByteView datagram)>;

  virtual ~DatagramPort() = default;
  /// From now on pump() passes the datagrams of `channel` to `take`. Must not be called during
  /// pump().
  virtual tl::expected<void, MediumError> subscribe(const std::string& channel, Take take) = 0;
  /// Readable when pump() has something to do; -1 before the first subscription.
  virtual int descriptor() const = 0;
  /// Reads at most `most` arrived datagrams; never blocks. Returns true when there may be more. Any
  /// thread, but the port calls `take` from one thread at a time; must not be called from a `take`.
  virtual bool pump(int most = 1024) = 0;
  /// Sends a datagram. Returns false when the kernel refused it. Any thread.
  virtual bool publish(const std::string& channel, ByteView datagram) = 0;
};

/// Opens the ports of one network. Any thread.
class DatagramNetwork {
 public:
  virtual ~DatagramNetwork() = default;
  /// The guarantees of a sealed connection over this network.
  virtual const Capabilities& capabilities() const = 0;
  /// The name of this network in addresses, such as "239.255.76.67": letters, digits, '.' and '-'.
  virtual const std::string& name() const = 0;
  /// Bytes of the largest datagram; must be at least capabilities().largest_packet +
  /// packet_overhead (datagram.hpp).
  virtual std::size_t largest_datagram() const = 0;
  virtual tl::expected<std::unique_ptr<DatagramPort>, MediumError> open(
      std::uint16_t port) const = 0;
  /// The network that an address calls `name`; usually this network.
  virtual std::shared_ptr<const DatagramNetwork> named(const std::string& name) const = 0;
  /// Text for the user when no server answers: what may keep packets from arriving. May be empty.
  virtual std::string advice() const { return {}; }
};

struct SealedOptions {
  std::shared_ptr<const DatagramNetwork> network{};
  std::uint16_t well_known_port = 0;  ///< the port of all well-known addresses
  /// Directory of the keys; empty: crypto::KeyDirectory::default_path(). Opened on first use.
  std::string key_directory{};
  crypto::RekeyRule rekey{};
  /// The clock for retries and rekeying; null: the system's. Must outlive the medium and its
  /// connections.
  const Clock* clock = nullptr;

  /// The time by CLOCK_BOOTTIME, so that the age of a packet in a socket includes the time in which
  /// the machine was suspended.
  TimePoint now() const {
    return clock != nullptr ? clock->since_boot() : SystemClock().since_boot();
  }
  /// The result of now() in ns, as sent in packets.
  std::int64_t now_ns() const { return now().time_since_epoch().count(); }
};

/// A medium of sealed connections over `options.network`. Both ends prove their keys to each other,
/// and each must have admitted the other's key (gecos/crypto/key_directory.hpp). Altered, forged
/// and replayed packets are discarded.
std::unique_ptr<Medium> make_sealed(SealedOptions options);

}  // namespace gecos::media
