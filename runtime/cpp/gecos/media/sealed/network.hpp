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

/// The interface between a medium whose packets other programs can read, and the code that encrypts
/// the packets.
///
/// The medium provides ports that send and receive datagrams. Datagrams may be lost, repeated and
/// reordered. Anybody may read the datagrams and send forged datagrams. For all of these media, the
/// code in this folder implements the proof of keys, the encryption, connections and streams.
/// docs/protocol.md is normative for the bytes of the datagrams.
namespace gecos::media {

/// One numbered port of a network. It sends datagrams to channels, and receives the datagrams of
/// channels.
class DatagramPort {
 public:
  using Take = std::function<void(ByteView datagram)>;

  virtual ~DatagramPort() = default;
  /// Makes pump() pass the datagrams of `channel` to `take` from now on. Returns the number of the
  /// subscription. Any thread may call this function, but a `take` function must not.
  virtual tl::expected<std::uint64_t, MediumError> subscribe(const std::string& channel,
                                                             Take take) = 0;
  /// Ends a subscription, and waits until its `take` function has returned. Any thread may call
  /// this function, but a `take` function must not.
  virtual void unsubscribe(std::uint64_t subscription) = 0;
  /// Returns a file descriptor that is readable when pump() has something to do; -1 before the
  /// first subscription.
  virtual int descriptor() const = 0;
  /// Reads at most `most` datagrams that have arrived. Never blocks. Returns true when there may be
  /// more datagrams. Any thread may call this function, but a `take` function must not. The port
  /// calls the `take` functions from one thread at a time.
  virtual bool pump(int most = 1024) = 0;
  /// Sends a datagram. Returns false when the kernel refused the datagram. Any thread may call this
  /// function.
  virtual bool publish(const std::string& channel, ByteView datagram) = 0;
};

/// Opens the ports of one network. Any thread may use a DatagramNetwork.
class DatagramNetwork {
 public:
  virtual ~DatagramNetwork() = default;
  /// Returns the guarantees of a sealed connection over this network.
  virtual const Capabilities& capabilities() const = 0;
  /// Returns the name of this network in addresses, for example "239.255.76.67". The name consists
  /// of letters, digits, '.' and '-'.
  virtual const std::string& name() const = 0;
  /// Returns the size of the largest datagram in bytes. The size must be at least
  /// capabilities().largest_packet + packet_overhead (datagram.hpp).
  virtual std::size_t largest_datagram() const = 0;
  /// Opens the port `port` for the caller alone.
  virtual tl::expected<std::unique_ptr<DatagramPort>, MediumError> open(
      std::uint16_t port) const = 0;
  /// Returns the port `port`, which all callers in this process share. It stays open as long as one
  /// of them holds it.
  virtual tl::expected<std::shared_ptr<DatagramPort>, MediumError> shared(
      std::uint16_t port) const = 0;
  /// Returns the number of the port on which a new connection is to receive; the caller passes the
  /// number to shared(). If a network returns a number again, several connections share the port.
  virtual std::uint16_t draw_reply_port() const = 0;
  /// Returns the network whose name in addresses is `name`. Usually this is the network on which
  /// the function is called.
  virtual std::shared_ptr<const DatagramNetwork> named(const std::string& name) const = 0;
  /// Returns a text for the user when no server answers. The text says why packets may not arrive.
  /// It may be empty.
  virtual std::string advice() const { return {}; }
};

struct SealedOptions {
  std::shared_ptr<const DatagramNetwork> network{};
  std::uint16_t well_known_port = 0;  ///< the port of all well-known addresses
  std::uint16_t open_port = 0;        ///< the port of all open channels; 0: there are none
  /// The path of the key directory. The directory is opened at its first use. If the path is empty,
  /// crypto::KeyDirectory::default_path() is used.
  std::string key_directory{};
  crypto::RekeyRule rekey{};
  /// The clock for repeated sending and for changes of the keys. If null, the system's clock is
  /// used. The clock must outlive the medium and its connections.
  const Clock* clock = nullptr;

  /// Returns the time by CLOCK_BOOTTIME. With this clock, the age of a packet that waits in a
  /// socket includes the time in which the machine was suspended.
  TimePoint now() const {
    return clock != nullptr ? clock->since_boot() : SystemClock().since_boot();
  }
  /// Returns the result of now() in ns, which is the form of the time in packets.
  std::int64_t now_ns() const { return now().time_since_epoch().count(); }
};

/// Makes a medium whose connections send encrypted packets over `options.network`. Both ends of a
/// connection prove to each other that they own their keys, and each end must have admitted the key
/// of the other end (gecos/crypto/key_directory.hpp). Altered, forged and replayed packets are
/// discarded.
std::unique_ptr<Medium> make_sealed(SealedOptions options);

}  // namespace gecos::media
