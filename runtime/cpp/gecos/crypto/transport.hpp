#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/result.hpp"
#include "gecos/crypto/aead.hpp"
#include "gecos/crypto/replay_window.hpp"

/// Encryption of the packets of one direction of a channel. Packets may be lost, repeated or
/// reordered on their way. The receiver delivers each packet at most once, and unaltered.
///
/// A sealed packet is called a frame. It consists of a counter (8 bytes, big-endian), the encrypted
/// packet and a tag (16 bytes). The upper half of the counter is the generation of the key. The
/// lower half numbers the packets of a generation from 0. The key of the next generation is
/// computed from the previous key by the function REKEY of Noise. Therefore stolen keys cannot
/// decrypt earlier packets, and a change of the key needs no message. The whole counter is the
/// nonce. In generation 0 the encryption equals that of the transport messages of Noise.
///
///     Bytes frame(Sealer::overhead + packet.size());
///     std::ranges::copy(packet, frame.begin() + Sealer::text_at);
///     sealer.seal(header, frame);               // header is sent in clear, but authenticated
///     …
///     if (auto packet = opener.open(header, frame)) deliver(*packet);  // lies within `frame`
///
/// The classes Sealer and Opener do not allocate, lock or read a clock. Only one thread at a time
/// may use a Sealer or an Opener. A forked child must not use a Sealer of its parent, because two
/// packets with the same counter reveal their contents.
namespace gecos::crypto {

/// Says when one direction of a channel changes to its next key: after the time `after`, or after
/// the number `packets` of packets, whichever is reached first.
struct RekeyRule {
  Duration after = std::chrono::minutes{2};
  std::uint32_t packets = 1U << 24;  ///< at least 1
};

class Sealer {
 public:
  static constexpr std::size_t text_at = 8;
  static constexpr std::size_t overhead = text_at + tag_bytes;

  Sealer(const Key& key, TimePoint now, RekeyRule rule = {});
  Sealer(Sealer&&) = default;
  Sealer(const Sealer&) = delete;  // a copy would use the same counters again

  /// Encrypts in place the packet in `frame`. The packet begins at the offset text_at and ends
  /// tag_bytes before the end of `frame`. `associated` is not sent; the receiver must pass
  /// identical data to Opener::open(). @pre `frame` has at least `overhead` bytes.
  void seal(ByteView associated, std::span<std::byte> frame);

  /// Changes the key when RekeyRule::after has passed. Must be called regularly, at least ten times
  /// in the time RekeyRule::after.
  void on_tick(TimePoint now);

  std::uint32_t generation() const { return generation_; }

 private:
  void next_generation();

  const RekeyRule rule_;
  Key key_;
  TimePoint since_;
  std::uint32_t generation_ = 0;
  std::uint32_t number_ = 0;  // number of the next packet
};

enum class OpenProblem : std::uint8_t {
  TooShort,  ///< shorter than a frame
  Replayed,  ///< the packet was delivered already
  TooOld,    ///< the number is over 1000 below the newest one, or the packet's key is erased
  TooNew,    ///< the peer cannot use this generation of the key yet
  Forged,    ///< not from the peer, not for this channel, or altered
};
std::string_view to_string(OpenProblem problem);

class Opener {
 public:
  /// A packet may be ahead of the newest opened packet by at most this number of generations. A
  /// limit is needed because a forged frame can name any generation, and each generation costs the
  /// computation of a key.
  static constexpr std::uint32_t most_lost_generations = 8;
  /// For this time after a change of the key, packets that were sealed under the previous key can
  /// still be opened.
  static constexpr Duration previous_kept = std::chrono::seconds{1};

  explicit Opener(const Key& key);

  /// Decrypts `frame` in place and returns the packet, which lies within `frame`. On failure the
  /// Opener does not change, and the contents of `frame` are lost.
  tl::expected<std::span<std::byte>, OpenProblem> open(ByteView associated,
                                                       std::span<std::byte> frame);

  /// Must be called at every heartbeat. The first call after a change of the key starts the time
  /// `previous_kept`. A call after the end of this time erases the previous key.
  void on_tick(TimePoint now);

  /// Returns true when a packet was opened. This proves that the peer has the keys, and that the
  /// handshake was not a replay.
  bool opened_any() const { return opened_any_; }
  std::uint32_t generation() const { return current_.number; }

 private:
  struct Generation {
    std::uint32_t number = 0;
    Key key;
    ReplayWindow seen;
  };
  tl::expected<std::span<std::byte>, OpenProblem> open_with(Generation& generation,
                                                            std::uint64_t counter,
                                                            ByteView associated,
                                                            std::span<std::byte> frame);
  tl::expected<std::span<std::byte>, OpenProblem> open_newer(std::uint64_t counter,
                                                             ByteView associated,
                                                             std::span<std::byte> frame);

  Generation current_;
  std::optional<Generation> previous_;
  std::optional<TimePoint> previous_since_;
  bool opened_any_ = false;
};

}  // namespace gecos::crypto
