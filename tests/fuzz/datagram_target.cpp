// What a port of the lcm medium hears: strangers, who have no key, and a peer who has one.
#include <array>
#include <map>
#include <set>
#include <vector>

#include "gecos/crypto/handshake_acceptor.hpp"
#include "gecos/crypto/handshake_initiator.hpp"
#include "gecos/media/lcm/receiver.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/receive_queue.hpp"
#include "pieces_target.hpp"
#include "script.hpp"
#include "targets.hpp"

namespace gecos::fuzz {
namespace {

using namespace gecos::media;

/// Whatever is read is read again from what it is written as.
void read_as_anything(ByteView bytes) {
  if (const auto message = LcmMessage::read(bytes)) {
    expect(message->channel.size() + message->content.size() + 9 == bytes.size(),
           "a message is a whole");
    if (const auto datagram = DatagramHeader::read(message->content)) {
      std::array<std::byte, DatagramHeader::bytes> again;
      datagram->write(again);
      const auto same = DatagramHeader::read(again);
      expect(same && same->kind == datagram->kind && same->client == datagram->client &&
                 same->reply_port == datagram->reply_port,
             "a datagram's header is read again");
    }
  }
  if (const auto inner = InnerHeader::read(bytes)) {
    std::array<std::byte, InnerHeader::bytes> again;
    inner->write(again);
    expect(std::ranges::equal(again, bytes.first(InnerHeader::bytes)),
           "what was sealed is read again");
  }
  if (const auto stream = SharedStream::read(bytes)) {
    std::array<std::byte, SharedStream::bytes> again;
    stream->write(again);
    expect(std::ranges::equal(again, bytes), "a shared stream is read again");
  }
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const std::string& tried : {text, "lcm:" + text}) {
    const auto address = SealedAddress::parse(tried);
    if (!address) continue;
    const auto same = SealedAddress::parse(address->to_string());
    expect(same && same->to_string() == address->to_string(), "an address is read again");
  }
}

/// An honest frame, until it was bent. True: it was.
bool bend(Script& script, Bytes& frame) {
  const Bytes before = frame;
  switch (script.below(4)) {
    case 0:
      break;
    case 1:
      frame.resize(script.word() % (frame.size() + 1));
      break;
    case 2:
      frame.push_back(std::byte{script.byte()});
      break;
    case 3:
      for (std::size_t bits = 1 + script.below(4); bits > 0; --bits) {
        frame[script.word() % frame.size()] ^= std::byte{script.byte()};
      }
      break;
  }
  return frame != before;
}

void try_handshake(Script script) {
  static const crypto::Identity client(crypto::KeyPair::draw());
  static const crypto::Identity server(crypto::KeyPair::draw());
  const Bytes context = script.bytes(20);
  const bool admitted = !script.one_in(8);
  crypto::HandshakeAcceptor acceptor(server, [admitted](const auto&) { return admitted; },
                                     {.burst = 1 + static_cast<std::uint32_t>(script.below(8)),
                                      .remembered = 1 + script.below(4)});
  const auto initiator =
      crypto::HandshakeInitiator::begin(client, server.public_key(), context, script.bytes(10));
  TimePoint now{std::chrono::hours(1)};
  Bytes second;
  std::size_t channels = 0;
  for (int step = 0; step < 12 && !script.over(); ++step) {
    now += std::chrono::milliseconds(script.byte() * 30);
    if (script.one_in(4)) {
      static_cast<void>(initiator->finish(script.bytes(255), now));
      expect(!acceptor.answer(script.bytes(255), context, {}, now), "noise is no handshake");
      continue;
    }
    Bytes first = initiator->first();
    const bool bent = bend(script, first);
    const auto answer = acceptor.answer(first, context, {}, now);
    expect(!answer || !bent, "no message that was altered is answered");
    expect(!answer || admitted, "who is not admitted is not answered");
    if (!answer) continue;
    channels += answer->channel ? 1 : 0;
    expect(channels <= 1, "a message that is repeated opens no second channel");
    second = answer->second;
    const bool altered = bend(script, second);
    const auto opened = initiator->finish(second, now);
    expect(opened.has_value() == !altered,
           "the answer as it was sent, and only that, opens the channel");
  }
}

/// The receive queue of a connection, whose peer has the channel's keys and seals what it likes,
/// and whose port anybody may write to.
void try_receive_queue(Script script) {
  const crypto::Key key;
  TimePoint now{std::chrono::hours(1)};
  const crypto::RekeyRule rule{.packets = 1 + static_cast<std::uint32_t>(script.below(8))};
  crypto::Sealer sealer(key, now, rule);
  ReceiveQueue queue{crypto::Opener(key)};
  std::vector<Bytes> wire;                     // what was sealed, oldest first
  std::map<std::uint64_t, Bytes> not_arrived;  // of packets that were sealed: by number
  std::uint64_t numbers = 0;
  constexpr std::array<std::byte, DatagramHeader::bytes> header{};
  for (int step = 0; step < 200 && !script.over(); ++step) {
    now += std::chrono::milliseconds(script.byte());
    switch (script.below(8)) {
      case 0:
      case 1:
      case 2: {
        Bytes text = script.bytes(100);
        const bool is_packet = !script.one_in(3);
        if (is_packet) text.resize(std::max(text.size(), InnerHeader::bytes));
        if (is_packet) {
          const InnerHeader inner{InnerKind::Packet, ++numbers,
                                  static_cast<std::int64_t>(script.number())};
          inner.write(std::span(text).first<InnerHeader::bytes>());
          not_arrived[numbers] = {text.begin() + InnerHeader::bytes, text.end()};
        } else if (!text.empty() &&
                   text[0] == std::byte{static_cast<std::uint8_t>(InnerKind::Packet)}) {
          break;  // it would be a packet that is not known here
        }
        Bytes frame(crypto::Sealer::overhead + text.size());
        std::ranges::copy(text, frame.begin() + crypto::Sealer::text_at);
        sealer.seal(header, frame);
        wire.push_back(std::move(frame));
        break;
      }
      case 3:
      case 4: {
        if (wire.empty()) break;
        Bytes frame =
            wire[wire.size() - 1 - script.byte() % wire.size()];  // newest, older, or again
        queue.take(header, frame, now);
        break;
      }
      case 5: {
        Bytes frame = wire.empty() ? script.bytes(200) : wire[script.byte() % wire.size()];
        const std::uint64_t before = queue.beats();
        const bool bent = wire.empty() || bend(script, frame);
        queue.take(header, frame, now);
        expect(!bent || queue.beats() == before, "nothing that was forged or altered is opened");
        break;
      }
      case 6: {
        ReceiveQueue::Packet packet;
        expect(queue.has_packets() == queue.pop(packet), "what is there is given");
        if (packet.frame.empty()) break;
        const ByteView got = ReceiveQueue::packet_in(packet.frame);
        const auto sent = std::ranges::find_if(
            not_arrived, [&](const auto& one) { return std::ranges::equal(one.second, got); });
        expect(sent != not_arrived.end(), "what arrives was sent, and arrives once");
        not_arrived.erase(sent);
        break;
      }
      case 7:
        queue.on_tick(now);
        sealer.on_tick(now);
        expect(queue.notices().size() <= 1024, "notices are bounded");
        break;
    }
  }
}

}  // namespace

void try_datagrams(ByteView input) {
  Script script(input);
  switch (script.below(8)) {
    case 0:
      return read_as_anything(input.subspan(std::min<std::size_t>(1, input.size())));
    case 1:
      return try_handshake(script);
    case 2:
    case 3:
    case 4:
      return try_receive_queue(script);
    default:
      return try_pieces(script);
  }
}

}  // namespace gecos::fuzz
