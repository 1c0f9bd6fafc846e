#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "gecos/base/bytes.hpp"
#include "gecos/base/result.hpp"
#include "gecos/crypto/transport.hpp"

/// Encryption of a stream's samples for many readers. The writer signs each sample, so that no
/// reader can forge a sample for other readers. It encrypts each sample under a key that all
/// admitted readers have.
///
/// A sealed sample is called a frame. It consists of a counter (8 bytes, big-endian), the encrypted
/// sample, an encrypted signature (64 bytes) and a tag (16 bytes). To exclude a reader, the writer
/// makes a new StreamSealer and sends its key to the other readers.
namespace gecos::crypto {

/// The keys that a reader of a stream needs. The writer sends them to each reader over the channel
/// between the two.
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

  /// Draws random keys. `next` is the counter of the first sample.
  explicit StreamSealer(std::uint64_t next = 0);
  StreamSealer(StreamSealer&&) = default;
  StreamSealer& operator=(StreamSealer&&) = default;
  StreamSealer(const StreamSealer&) = delete;  // a copy would use the same counters again

  const StreamKey& key() const { return key_; }
  /// Returns the counter of the next sample.
  std::uint64_t count() const { return next_; }
  /// Encrypts and signs, in place, the sample in `frame`. The sample begins at the offset text_at
  /// and ends `overhead - text_at` bytes before the end of `frame`. @pre `frame` has at least
  /// `overhead` bytes.
  void seal(ByteView associated, std::span<std::byte> frame);

 private:
  StreamKey key_;
  Secret<64> signing_;
  std::uint64_t next_ = 0;
};

/// Decrypts and checks the samples of a stream. Only one thread at a time may use a StreamOpener.
class StreamOpener {
 public:
  explicit StreamOpener(const StreamKey& key) : key_(key) {}

  /// Decrypts `frame` in place and returns the sample in it, like Opener::open. Fails with Forged
  /// when the sample does not have the writer's signature.
  tl::expected<std::span<std::byte>, OpenProblem> open(ByteView associated,
                                                       std::span<std::byte> frame);

 private:
  StreamKey key_;
  ReplayWindow seen_;
};

}  // namespace gecos::crypto
