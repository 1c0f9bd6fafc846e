#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "gecos/base/bytes.hpp"
#include "gecos/base/result.hpp"
#include "gecos/crypto/transport.hpp"

/// Seals samples for many readers: encrypted under a key that all admitted readers have, signed by
/// the writer inside of that, so that no reader can forge a sample to the others.
///
/// A frame is a counter (8 bytes, big-endian), the sample and a signature (64 bytes), both
/// encrypted, and a tag (16 bytes). Who is no longer to read: make a new StreamSealer and tell the
/// others its key.
namespace gecos::crypto {

/// The keys of a reader, which it receives over its own channel.
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

  StreamSealer();  ///< draws its keys
  StreamSealer(StreamSealer&&) = default;
  StreamSealer(const StreamSealer&) = delete;  // a copy would use its counters again

  const StreamKey& key() const { return key_; }
  /// Seals in place what stands in `frame` from text_at up to its last overhead - text_at bytes.
  /// @pre `frame` has at least `overhead` bytes.
  void seal(ByteView associated, std::span<std::byte> frame);

 private:
  StreamKey key_;
  Secret<64> signing_;
  std::uint64_t next_ = 0;
};

/// One thread at a time.
class StreamOpener {
 public:
  explicit StreamOpener(const StreamKey& key) : key_(key) {}

  /// As Opener::open. A sample that only another reader can have written is Forged.
  tl::expected<std::span<std::byte>, OpenProblem> open(ByteView associated,
                                                       std::span<std::byte> frame);

 private:
  StreamKey key_;
  ReplayWindow seen_;
};

}  // namespace gecos::crypto
