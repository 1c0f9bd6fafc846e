#include "gecos/session/protocol/inward_sample.hpp"

#include "gecos/wire/decoder.hpp"
#include "gecos/wire/encoder.hpp"

namespace gecos::session {

void write_inward_header(std::span<std::byte, inward_header_size> to, const InwardHeader& header) {
  wire::Encoder(to).put(number(header.session), number(header.epoch), header.command);
}

tl::expected<InwardSample, wire::DecodeError> read_inward_sample(ByteView bytes) {
  InwardSample sample;
  wire::Decoder from(bytes);
  std::uint64_t session = 0;
  std::uint64_t epoch = 0;
  const bool decoded = from.get(session, "session") && from.get(epoch, "epoch") &&
                       from.get(sample.header.command, "command") &&
                       from.get_view(sample.value, from.remaining());
  if (!decoded) return tl::make_unexpected(from.error());
  sample.header.session = SessionId{session};
  sample.header.epoch = Epoch{epoch};
  return sample;
}

}  // namespace gecos::session
