#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gecos/media/medium.hpp"
#include "gecos/wire/packet.hpp"
#include "script.hpp"

namespace gecos::fuzz {

/// One end of a line whose other end is a script.
class ScriptedConnection final : public media::Connection {
 public:
  explicit ScriptedConnection(bool reliable, std::size_t largest = 2048) {
    capabilities_.reliable = reliable, capabilities_.largest_packet = largest;
  }

  const media::Capabilities& capabilities() const override { return capabilities_; }
  const media::Peer& peer() const override { return peer_; }
  tl::expected<std::uint64_t, media::SendProblem> send(ByteView head, ByteView body) override {
    if (lost != media::Loss::None) return tl::unexpected(media::SendProblem::Lost);
    if (full) return tl::unexpected(media::SendProblem::Full);
    expect(head.size() + body.size() <= capabilities_.largest_packet,
           "a packet is as large as the medium carries");
    if (heard) {
      const auto packet = wire::decode_packet(head);
      expect(packet.has_value(), "what a session sends can be read");
      heard(*packet);
    }
    return ++sent;
  }
  std::optional<ByteView> receive() override {
    if (!next) return std::nullopt;
    auto packet = next();
    if (!packet) return std::nullopt;
    current_ = std::move(*packet);
    return ByteView(current_);
  }
  Duration age() override { return age_of_packets; }
  std::optional<std::uint64_t> taken_by_peer() override { return taken; }
  bool prepare_to_sleep() override { return false; }  // nobody would wake us
  void woke() override {}
  std::span<const int> descriptors() const override { return {}; }
  void beat() override {}
  std::uint64_t beats_seen() override { return beats; }
  media::Loss loss() override { return lost; }
  std::string loss_text() const override {
    return lost == media::Loss::None ? "" : "the script says so";
  }
  std::unique_ptr<media::StreamWriter> make_stream(std::size_t, std::size_t) override {
    return nullptr;
  }
  tl::expected<void, media::SendProblem> share(std::uint32_t, media::StreamWriter&) override {
    if (full) return tl::unexpected(media::SendProblem::Full);
    return {};
  }
  void unshare(std::uint32_t) override {}
  std::unique_ptr<media::StreamReader> open_stream(std::uint32_t id,
                                                   const media::StreamBounds&) override {
    return stream ? stream(id) : nullptr;
  }

  std::function<void(const wire::PacketView&)> heard;  ///< of a session: what it sent
  std::function<std::optional<Bytes>()> next;
  std::function<std::unique_ptr<media::StreamReader>(std::uint32_t)> stream;
  Duration age_of_packets{0};
  std::optional<std::uint64_t> taken;
  std::uint64_t beats = 0;
  std::uint64_t sent = 0;
  bool full = false;
  media::Loss lost = media::Loss::None;

 private:
  media::Capabilities capabilities_;
  const media::Peer peer_;
  Bytes current_;
};

/// Any packet, or nearly one: the script bends one that stands for an honest one.
inline Bytes bent(Script& script, const wire::PacketHeader& header, ByteView body) {
  Bytes packet = wire::encode_packet(header, body, script.one_in(16) ? script.bytes(20) : Bytes{});
  if (!script.one_in(16)) return packet;
  switch (script.below(3)) {
    case 0:
      packet.resize(script.word() % (packet.size() + 1));
      break;
    case 1:
      packet.push_back(std::byte{script.byte()});
      break;
    case 2:
      packet[script.word() % packet.size()] ^= std::byte{script.byte()};
      break;
  }
  return packet;
}

}  // namespace gecos::fuzz
