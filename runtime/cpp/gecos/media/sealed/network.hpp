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
/// A medium provides ports that carry datagrams. Datagrams may be lost, repeated and reordered;
/// anybody may overhear them and send forged ones. Everything else is here, once for all such
/// media: proving keys, sealing, connections, streams. docs/protocol.md is normative for the bytes.
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
  /// thread; must not be called from a `take`.
  virtual bool pump(int most = 1024) = 0;
  /// Sends a datagram. Returns false when the kernel refused it. Any thread.
  virtual bool publish(const std::string& channel, ByteView datagram) = 0;
};

/// Where the ports are. Any thread.
class DatagramNetwork {
 public:
  virtual ~DatagramNetwork() = default;
  /// What a sealed connection over this network promises.
  virtual const Offer& offer() const = 0;
  /// A part of every address, of letters, digits, '.' and '-': "239.255.76.67".
  virtual const std::string& name() const = 0;
  /// Bytes. offer().largest_packet is at least packet_overhead (datagram.hpp) less.
  virtual std::size_t largest_datagram() const = 0;
  virtual tl::expected<std::unique_ptr<DatagramPort>, MediumError> open(
      std::uint16_t port) const = 0;
  /// The network that an address names; mostly this one.
  virtual std::shared_ptr<const DatagramNetwork> named(const std::string& name) const = 0;
  /// Readable text for the case that nobody answers: what may keep packets from arriving; may be
  /// empty.
  virtual std::string advice() const { return {}; }
};

struct SealedOptions {
  std::shared_ptr<const DatagramNetwork> network{};
  std::uint16_t well_known_port = 0;  ///< where all programs look up a place by its name
  /// Where the keys are; empty: crypto::KeyDirectory::default_path(). Opened with the first use.
  std::string key_directory{};
  crypto::RekeyRule rekey{};
  /// For retries and rekeying; null: the system's. Must outlive the medium and its links.
  const Clock* clock = nullptr;

  /// By CLOCK_BOOTTIME, so that the age of a packet in a socket includes the time in which the
  /// machine was suspended.
  TimePoint now() const {
    return clock != nullptr ? clock->since_boot() : SystemClock().since_boot();
  }
  /// The same in ns, as sent in packets.
  std::int64_t now_ns() const { return now().time_since_epoch().count(); }
};

/// A medium of sealed connections over `options.network`. Both ends prove their keys to each other
/// and must have admitted each other's (gecos/crypto/key_directory.hpp). A packet that was altered,
/// forged or replayed never arrives.
std::unique_ptr<Medium> make_sealed(SealedOptions options);

}  // namespace gecos::media
