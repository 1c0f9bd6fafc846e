#include "pieces_target.hpp"

#include <array>
#include <deque>
#include <memory>

#include "gecos/media/layers/fragments.hpp"
#include "gecos/media/layers/transfer.hpp"
#include "scripted_connection.hpp"

namespace gecos::fuzz {
namespace {

using namespace gecos::media;

constexpr std::size_t piece_bytes = 8 * 1024;

/// Connects to a script.
class ScriptedMedium final : public Medium {
 public:
  explicit ScriptedMedium(std::unique_ptr<Connection> connection)
      : capabilities_(connection->capabilities()), connection_(std::move(connection)) {}
  const Capabilities& capabilities() const override { return capabilities_; }
  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view, bool) override {
    return tl::unexpected(MediumError{"a script serves nobody"});
  }
  tl::expected<std::unique_ptr<Connection>, MediumError> connect(std::string_view) override {
    return std::move(connection_);
  }
  std::string well_known_address(std::string_view) const override { return {}; }

 private:
  const Capabilities capabilities_;
  std::unique_ptr<Connection> connection_;
};

Bytes piece_of(std::uint64_t transfer, std::size_t size, std::uint32_t index, std::size_t content) {
  Bytes packet(Piece::head_bytes + content, static_cast<std::byte>(transfer));
  Piece{transfer, static_cast<std::uint32_t>(size), index, {}}.write_head(
      std::span(packet).first<Piece::head_bytes>());
  return packet;
}

}  // namespace

void try_pieces(Script script) {
  auto made = std::make_unique<ScriptedConnection>(false, piece_bytes + Piece::head_bytes);
  ScriptedConnection& inner = *made;
  std::deque<Bytes> arriving;
  inner.next = [&]() -> std::optional<Bytes> {
    if (arriving.empty()) return std::nullopt;
    Bytes packet = std::move(arriving.front());
    arriving.pop_front();
    return packet;
  };
  FakeClock clock;
  const auto medium = make_fragmented(std::make_unique<ScriptedMedium>(std::move(made)), clock);
  const auto connection = std::move(*medium->connect({}));
  std::uint64_t transfer = 0;
  for (int step = 0; step < 100 && !script.over(); ++step) {
    switch (script.below(8)) {
      case 0: {  // an honest packet in pieces arrives, once, whatever was before
        const std::size_t size = piece_bytes + 1 + script.word() % (3 * piece_bytes);
        const auto pieces = static_cast<std::uint32_t>((size + piece_bytes - 1) / piece_bytes);
        ++transfer;
        for (std::uint32_t i = 0; i < 2 * pieces; ++i) {
          const std::uint32_t index = (i + script.byte()) % pieces;
          const std::size_t before = std::size_t{index} * piece_bytes;
          arriving.push_back(piece_of(transfer, size, index, std::min(piece_bytes, size - before)));
        }
        break;
      }
      case 1: {
        const std::uint64_t which = script.one_in(4) ? script.number() : transfer + script.below(3);
        const std::size_t size = script.one_in(2) ? script.number() : 20'000;
        const std::uint64_t index = script.one_in(4) ? script.number() : script.below(4);
        const std::size_t holds = script.one_in(2) ? piece_bytes : 20'000 % piece_bytes;
        arriving.push_back(piece_of(which, size, static_cast<std::uint32_t>(index), holds));
        break;
      }
      case 2: {
        std::array<std::byte, Received::bytes> bytes;
        Received{script.one_in(4) ? script.number() : script.below(4),
                 static_cast<std::uint32_t>(script.one_in(4) ? script.number() : script.below(8)),
                 static_cast<std::uint32_t>(script.number())}
            .write(bytes);
        arriving.emplace_back(bytes.begin(), bytes.end());
        break;
      }
      case 3:
        arriving.push_back(script.bytes(60));
        break;
      case 4: {
        const Bytes packet(script.word() % (8 * piece_bytes), std::byte{script.byte()});
        const auto sent = connection->send(packet, {});
        expect(sent || sent.error() != SendProblem::TooLarge, "what is small enough goes");
        break;
      }
      case 5:
        clock.advance(std::chrono::milliseconds(script.byte()));
        connection->beat();
        break;
      case 6:
        inner.full = !inner.full;
        break;
      case 7:
        while (const auto packet = connection->receive()) {
          expect(packet->size() <= largest_transfer, "no packet is larger than the largest");
        }
        break;
    }
  }
}

}  // namespace gecos::fuzz
