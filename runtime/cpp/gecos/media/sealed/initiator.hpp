#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "gecos/base/mutex.hpp"
#include "gecos/crypto/handshake_initiator.hpp"
#include "gecos/media/sealed/keys.hpp"
#include "gecos/media/sealed/network.hpp"
#include "gecos/media/sealed/receive_queue.hpp"
#include "gecos/media/sealed/sender.hpp"

namespace gecos::media {

/// Opens the channel of a client. First the initiator asks for the server's key, if the address has
/// no key. Then it repeats the first handshake message until the server answers. Then it repeats a
/// heartbeat until the first sealed packet of the server arrives. No function waits, so the owner
/// of the connection must call advance() often. Any thread may use a HandshakeInitiator.
class HandshakeInitiator {
 public:
  /// After this time without an answer, the handshake starts again, because the server has then
  /// forgotten the handshake.
  static constexpr Duration begins_anew_after = std::chrono::seconds{5};

  HandshakeInitiator(std::shared_ptr<const SealedKeys> keys, const SealedOptions& options,
                     SealedAddress address, std::shared_ptr<SealedSender> sender,
                     std::shared_ptr<ReceiveQueue> queue);

  /// Sends the messages that are due. Does nothing after a sealed packet of the server has arrived.
  void advance();
  /// Processes a message of the handshake from the server. The kind of the message is Key (the
  /// public key of the server) or Second (the second message of the Noise handshake).
  void take(const DatagramHeader& header, ByteView frame);
  /// Returns a text for the user that says why there is no connection yet. The text is empty after
  /// the server has answered on the channel.
  std::string trouble() const;

 private:
  struct Refused {
    crypto::PublicKey key;
    std::string why;
  };
  void begin(TimePoint now) GECOS_REQUIRES(mutex_);
  void begin_with(const crypto::PublicKey& key) GECOS_REQUIRES(mutex_);
  void take_key(ByteView frame, TimePoint now) GECOS_REQUIRES(mutex_);
  void take_second(ByteView frame, TimePoint now) GECOS_REQUIRES(mutex_);
  void speak(TimePoint now) GECOS_REQUIRES(mutex_);

  const std::shared_ptr<const SealedKeys> keys_;
  const SealedOptions options_;
  const SealedAddress address_;
  const std::shared_ptr<SealedSender> sender_;
  const std::shared_ptr<ReceiveQueue> queue_;
  std::atomic<bool> over_{false};  // tells advance() that nothing is left to do
  mutable Mutex mutex_;
  std::optional<crypto::HandshakeInitiator> handshake_ GECOS_GUARDED_BY(mutex_);
  std::optional<Refused> not_admitted_ GECOS_GUARDED_BY(mutex_);
  bool open_ GECOS_GUARDED_BY(mutex_) = false;
  int said_ GECOS_GUARDED_BY(mutex_) = 0;
  TimePoint began_ GECOS_GUARDED_BY(mutex_);
  TimePoint next_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::media
