#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gecos/base/bytes.hpp"
#include "gecos/base/ids.hpp"
#include "gecos/base/result.hpp"
#include "gecos/wire/decode_error.hpp"

namespace gecos::session {

/// The origin of a sample of an inward stream. It precedes the value in every sample that a client
/// sends. The server uses it to ignore samples that arrive late: a sample that was sent for an
/// earlier command, or under a status that has ended, must not correct a later motion.
struct InwardHeader {
  SessionId session{};
  Epoch epoch{};  ///< the epoch of the status under which the client sends the sample
  /// The counter, in this session, of the command that the sample feeds; 0 when the sample feeds no
  /// command.
  std::uint64_t command = 0;

  friend bool operator==(const InwardHeader&, const InwardHeader&) = default;
};

/// The size of the header is a multiple of 8, so that a value in lent memory stays aligned.
inline constexpr std::size_t inward_header_size = 8 + 8 + 8;

/// Writes `header` to the bytes directly before the value. These bytes may be memory that the
/// medium has lent.
void write_inward_header(std::span<std::byte, inward_header_size> to, const InwardHeader& header);

/// A decoded sample. `value` borrows the bytes that were decoded, and may be empty.
struct InwardSample {
  InwardHeader header;
  ByteView value;
};

tl::expected<InwardSample, wire::DecodeError> read_inward_sample(ByteView bytes);

}  // namespace gecos::session
