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

/// One direction of a channel: packets that may be lost, repeated or overtake each other on their
/// way, and are delivered at most once, unaltered, or not at all.
///
/// A frame is a counter (8 bytes, big-endian), the packet encrypted, and a tag (16 bytes). The
/// upper half of the counter is the key's generation, the lower half numbers the packets of it from
/// 0. The key of a generation is Noise's REKEY of the one before, so what was sent cannot be read
/// with keys that are found later, and a new key needs no message and no answer. The whole counter
/// is the nonce; in generation 0 a frame is what Noise's transport messages are.
///
///     Bytes frame(Sealer::overhead + packet.size());
///     std::ranges::copy(packet, frame.begin() + Sealer::text_at);
///     sealer.seal(header, frame);               // header travels in clear, and is protected too
///     …
///     if (auto packet = opener.open(header, frame)) deliver(*packet);  // lies within `frame`
///
/// Neither allocates, locks or reads a clock. One thread at a time, of each half. A forked child
/// must not seal with what it inherited: two packets under one counter give their contents away.
namespace gecos::crypto {

/// When a direction goes over to its next key: what comes first.
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
  Sealer(const Sealer&) = delete;  // a copy would use its counters again

  /// Seals in place what stands in `frame` from text_at up to its last tag_bytes. `associated` is
  /// not sent; the opener must name the same. @pre `frame` has at least `overhead` bytes.
  void seal(ByteView associated, std::span<std::byte> frame);

  /// Must be called regularly, at least every tenth of RekeyRule::after.
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
  TooShort,  ///< no frame
  Replayed,  ///< delivered already
  TooOld,    ///< overtaken by a thousand others, or its key is erased
  TooNew,    ///< under a key that the peer cannot have reached
  Forged,    ///< not from the peer, not for this channel, or altered
};
std::string_view to_string(OpenProblem problem);

class Opener {
 public:
  /// How many generations may have been lost as a whole. Bounds what a forged frame can cost.
  static constexpr std::uint32_t most_lost_generations = 8;
  /// How long packets under the previous key are still opened after the key changed.
  static constexpr Duration previous_kept = std::chrono::seconds{1};

  explicit Opener(const Key& key);

  /// Opens in place and gives the packet, which lies within `frame`. What fails changes nothing
  /// here, and leaves `frame` unusable.
  tl::expected<std::span<std::byte>, OpenProblem> open(ByteView associated,
                                                       std::span<std::byte> frame);

  /// Erases the previous key some time after it was replaced: previous_kept after the first call
  /// that follows. To be called with every beat.
  void on_tick(TimePoint now);

  /// Whether anything was opened: the peer has the key, now and not in a recording.
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
