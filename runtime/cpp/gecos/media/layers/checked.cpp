#include "gecos/media/layers/checked.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "gecos/media/layers/layer.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t check_size = sizeof(std::uint32_t);

constexpr std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t at = 0; at < table.size(); ++at) {
    std::uint32_t rest = at;
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1) ^ ((rest & 1) != 0 ? 0x82f63b78u : 0u);
    table[at] = rest;
  }
  return table;
}

Capabilities capabilities_when_checked(const Medium& inner) {
  Capabilities capabilities = inner.capabilities();
  capabilities.intact = true;
  capabilities.largest_packet -= check_size;
  return capabilities;
}

class CheckedConnection final : public ConnectionLayer {
 public:
  using ConnectionLayer::ConnectionLayer;

  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override {
    if (head.size() + body.size() > capabilities().largest_packet) {
      return tl::unexpected(SendProblem::TooLarge);
    }
    const std::uint32_t sum = crc32c(body, crc32c(head));
    std::array<std::byte, check_size> check;
    for (std::size_t at = 0; at < check_size; ++at) {
      check[at] = static_cast<std::byte>(sum >> (8 * (check_size - 1 - at)));
    }
    outgoing_.resize(check_size + head.size());
    std::ranges::copy(head, std::ranges::copy(check, outgoing_.begin()).out);
    return inner().send(outgoing_, body);
  }

  std::optional<ByteView> receive() override {
    while (const auto packet = inner().receive()) {
      if (packet->size() < check_size) continue;
      std::uint32_t sum = 0;
      for (const std::byte byte : packet->first(check_size)) {
        sum = sum << 8 | static_cast<std::uint32_t>(byte);
      }
      const ByteView rest = packet->subspan(check_size);
      if (crc32c(rest) == sum) return rest;
    }
    return std::nullopt;
  }

 private:
  Bytes outgoing_;  ///< reused by every send()
};

}  // namespace

std::uint32_t crc32c(ByteView bytes, std::uint32_t before) {
  static constexpr auto table = make_table();
  std::uint32_t sum = ~before;
  for (const std::byte byte : bytes) {
    sum = (sum >> 8) ^ table[(sum ^ static_cast<std::uint32_t>(byte)) & 0xff];
  }
  return ~sum;
}

std::unique_ptr<Medium> make_checked(std::unique_ptr<Medium> inner) {
  const Capabilities layer_capabilities = capabilities_when_checked(*inner);
  return make_layer(
      std::move(inner), layer_capabilities,
      [](std::unique_ptr<Connection> connection, const Capabilities& capabilities, Role) {
        return std::make_unique<CheckedConnection>(std::move(connection), capabilities);
      });
}

}  // namespace gecos::media
