#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "gecos/base/bytes.hpp"
#include "gecos/base/result.hpp"
#include "gecos/crypto/transport.hpp"

/// Seals samples for many readers. The writer signs each sample, so that no reader can forge a
/// sample for the others, and encrypts it under a key that all admitted readers have.
///
/// A frame is a counter (8 bytes, big-endian), the sample and a signature (64 bytes), both
/// encrypted, and a tag (16 bytes). To exclude a reader, make a new StreamSealer and send its key
/// to the other readers.
namespace gecos::crypto {

/// The keys that a reader needs. Each reader receives them over its own channel.
struct StreamKey {
  static constexpr std::size_t bytes = 64;

  Key key;
  std::array<std::byte, 32> signer{};  ///< Ed25519

  void write(std::span<std::byte, bytes> to) const;
  static StreamKey read(std::span<const std::byte, bytes> from);
};

class StreamSealer {
 public:
  static constexpr std::size_t signature_bytes = 64;
  static constexpr std::size_t text_at = Sealer::text_at;
  static constexpr std::size_t overhead = Sealer::overhead + signature_bytes;

  StreamSealer();  ///< draws random keys
  StreamSealer(StreamSealer&&) = default;
  StreamSealer(const StreamSealer&) = delete;  // a copy would use the same counters again

  const StreamKey& key() const { return key_; }
  /// Seals in place the sample in `frame`, which begins at text_at and is followed by overhead -
  /// text_at bytes. @pre `frame` has at least `overhead` bytes.
  void seal(ByteView associated, std::span<std::byte> frame);

 private:
  StreamKey key_;
  Secret<64> signing_;
  std::uint64_t next_ = 0;
};

/// Opens the samples of a stream. Only one thread at a time may use a StreamOpener.
class StreamOpener {
 public:
  explicit StreamOpener(const StreamKey& key) : key_(key) {}

  /// Like Opener::open. A sample without the writer's signature is Forged.
  tl::expected<std::span<std::byte>, OpenProblem> open(ByteView associated,
                                                       std::span<std::byte> frame);

 private:
  StreamKey key_;
  ReplayWindow seen_;
};

}  // namespace gecos::crypto
