#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <list>
#include <map>
#include <memory>
#include <optional>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/crypto/handshake_acceptor.hpp"
#include "gecos/media/sealed/keys.hpp"
#include "gecos/media/sealed/network.hpp"
#include "gecos/media/sealed/receive_queue.hpp"
#include "gecos/media/sealed/sender.hpp"

namespace gecos::media {

/// The part that the acceptor of an object shares with its connections: the port that receives the
/// datagrams of all clients, and the handshake. A client counts as connected after one of its
/// sealed packets was decrypted. A replayed handshake never leads to a decrypted packet, so that an
/// attacker with a replay cannot take the place of a client and occupies no descriptor.
class HandshakeResponder {
 public:
  /// A client that has connected and that the acceptor has not accepted yet.
  struct PendingPeer {
    std::uint64_t client = 0;
    std::uint16_t reply_port = 0;
    crypto::PublicKey key;
    crypto::KeyOwner owner;  ///< empty for a key without an owner, and for our own key
    crypto::Sealer sealer;
    std::shared_ptr<ReceiveQueue> queue;
  };
  HandshakeResponder(SealedOptions options, std::shared_ptr<const SealedKeys> keys,
                     std::unique_ptr<DatagramPort> in, SealedAddress address);

  tl::expected<void, MediumError> open();
  /// Puts the datagrams that have arrived into the queues of the connections and of the clients
  /// that are not accepted yet. Returns true when there may be more datagrams.
  bool pump() { return in_->pump(); }
  std::optional<PendingPeer> next_pending();
  void forget(std::uint64_t client);
  /// Tells a client that it is refused, and why. A datagram may be lost; therefore the answer is
  /// repeated for each datagram that the client sends in the next seconds. Meanwhile, no port is
  /// kept open for the client.
  void refuse(PendingPeer client, const std::string& why);
  /// Makes a stream for all clients of the object. Throws std::runtime_error when the port of the
  /// stream cannot be opened. Any thread may call this function.
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth);

  int descriptor() const { return in_->descriptor(); }
  /// Returns the eventfd that pump() notifies when a client has connected.
  EventFd& event() { return event_; }
  const SealedOptions& options() const { return options_; }
  const std::shared_ptr<const SealedKeys>& keys() const { return keys_; }
  const SealedAddress& address() const { return address_; }
  void close() { closed_.store(true); }

 private:
  /// Allows a limited number of actions per second.
  class Budget {
   public:
    explicit Budget(unsigned per_second) : per_second_(per_second) {}
    bool take(TimePoint now);

   private:
    const unsigned per_second_;
    std::optional<TimePoint> since_;
    unsigned taken_ = 0;
  };
  /// A handshake that was answered, but whose client has not yet proved that it has the keys.
  struct Unconfirmed {
    std::uint64_t client = 0;
    std::uint16_t reply_port = 0;
    TimePoint since;
    crypto::Channel channel;
  };
  /// A client that was told why it is refused.
  struct RefusedPeer {
    std::uint64_t client = 0;
    std::uint16_t reply_port = 0;
    TimePoint since;
    std::shared_ptr<const Bytes> datagram;  ///< says why; sent as often as needed
  };
  /// The clients that were refused in the last seconds.
  class RefusedPeers {
   public:
    void add(RefusedPeer peer);
    /// If `client` was refused in the last seconds and must get the answer again, returns the data
    /// of the refusal; otherwise no value.
    std::optional<RefusedPeer> again(std::uint64_t client, TimePoint now);

   private:
    std::list<RefusedPeer> peers_;  // oldest first
    Budget repeats_{50};
  };
  void take(ByteView datagram);
  void take_first(const DatagramHeader& header, ByteView datagram, TimePoint now);
  void take_sealed(const DatagramHeader& header, ByteView datagram);
  void confirm(const DatagramHeader& header, ByteView datagram) GECOS_REQUIRES(mutex_);
  void tell(const RefusedPeer& refused) const;
  std::optional<crypto::KeyOwner> owner_of(const crypto::PublicKey& key) const;
  void answer(const DatagramHeader& to, DatagramKind kind, ByteView frame, TimePoint now);

  const SealedOptions options_;
  const std::shared_ptr<const SealedKeys> keys_;
  const std::unique_ptr<DatagramPort> in_;
  const SealedAddress address_;
  EventFd event_;
  std::atomic<bool> closed_{false};  // the acceptor is destroyed: no further client is accepted
  // The following members are used only in take(), which the port calls from one thread at a time.
  crypto::HandshakeAcceptor handshakes_;
  Budget answers_{400};
  Budget warnings_{1};

  const std::uint16_t stream_port_;
  Mutex mutex_;
  std::list<Unconfirmed> unconfirmed_ GECOS_GUARDED_BY(mutex_);  // oldest first
  RefusedPeers refused_ GECOS_GUARDED_BY(mutex_);
  std::map<std::uint64_t, std::shared_ptr<ReceiveQueue>> queues_ GECOS_GUARDED_BY(mutex_);
  std::deque<PendingPeer> pending_ GECOS_GUARDED_BY(mutex_);
  std::shared_ptr<DatagramPort> streams_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::media
