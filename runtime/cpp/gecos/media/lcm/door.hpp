#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "gecos/crypto/handshake_door.hpp"
#include "gecos/media/bell.hpp"
#include "gecos/media/lcm/inbox.hpp"
#include "gecos/media/lcm/keys.hpp"
#include "gecos/media/lcm/port.hpp"

namespace gecos::media {

/// What the acceptor of an object and its links share: the port where all clients' datagrams come
/// in, and the handshake. A client has come once something was opened that it sealed; what was
/// played back never gets so far, displaces nobody, and holds no descriptor.
class LcmDoor {
 public:
  /// A client that has come and was not yet accepted.
  struct Guest {
    std::uint64_t client = 0;
    std::uint16_t reply_port = 0;
    crypto::PublicKey key;
    crypto::Sealer sealer;
    std::shared_ptr<LcmInbox> inbox;
  };
  LcmDoor(LcmOptions options, std::shared_ptr<const LcmKeys> keys, std::unique_ptr<LcmPort> in,
          LcmAddress address);

  tl::expected<void, MediumError> open();
  /// Puts what has arrived into the inboxes of links and guests. True: there may be more.
  bool pump() { return in_->pump(); }
  std::optional<Guest> next_guest();
  void forget(std::uint64_t client);
  /// A stream for all clients of the object. Throws std::runtime_error when its port cannot be
  /// opened. Any thread.
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth);

  int descriptor() const { return in_->descriptor(); }
  /// Rung when a guest has come, by whoever pumps.
  Bell& bell() { return bell_; }
  const LcmOptions& options() const { return options_; }
  const LcmAddress& address() const { return address_; }
  void close() { closed_.store(true); }

 private:
  /// So many in each second.
  class Budget {
   public:
    explicit Budget(unsigned per_second) : per_second_(per_second) {}
    bool take(TimePoint now);

   private:
    const unsigned per_second_;
    std::optional<TimePoint> since_;
    unsigned taken_ = 0;
  };
  /// A handshake that was answered; who began it has yet to show that it has the keys.
  struct Unconfirmed {
    std::uint64_t client = 0;
    std::uint16_t reply_port = 0;
    TimePoint since;
    crypto::Channel channel;
  };
  void take(ByteView datagram);
  void take_first(const DatagramHeader& header, ByteView datagram, TimePoint now);
  void take_sealed(const DatagramHeader& header, ByteView datagram);
  void confirm(const DatagramHeader& header, ByteView datagram);
  void answer(const DatagramHeader& to, DatagramKind kind, ByteView frame, TimePoint now);

  const LcmOptions options_;
  const std::shared_ptr<const LcmKeys> keys_;
  const std::unique_ptr<LcmPort> in_;
  const LcmAddress address_;
  Bell bell_;
  std::atomic<bool> closed_{false};  // the acceptor has gone: nobody comes in any more
  // Of whoever pumps, one at a time:
  crypto::HandshakeDoor handshakes_;
  Budget answers_{400};
  Budget warnings_{1};
  std::mutex mutex_;                    // guards what follows
  std::list<Unconfirmed> unconfirmed_;  // oldest first
  std::map<std::uint64_t, std::shared_ptr<LcmInbox>> inboxes_;
  std::deque<Guest> guests_;
  const std::uint16_t stream_port_;
  std::shared_ptr<LcmPort> streams_;
};

}  // namespace gecos::media
