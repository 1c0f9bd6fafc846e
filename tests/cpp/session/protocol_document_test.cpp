// The examples of docs/protocol.md are what the code writes.

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "gecos/broker_calls.hpp"
#include "gecos/broker_interface.hpp"
#include "gecos/crypto/ik.hpp"
#include "gecos/crypto/transport.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/object_calls.hpp"
#include "gecos/object_interface.hpp"
#include "gecos/session/protocol/handshake.hpp"
#include "gecos/session/protocol/inward_sample.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/sample_time.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::session {
namespace {

using media::DatagramHeader;
using media::DatagramKind;
using media::InnerHeader;
using media::InnerKind;

std::string hex(ByteView bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    constexpr std::string_view digits = "0123456789abcdef";
    text += digits[std::to_integer<std::size_t>(byte) >> 4];
    text += digits[std::to_integer<std::size_t>(byte) & 0xf];
  }
  return text;
}

/// The blocks "```hex name": of each line what stands before the first space.
std::map<std::string, std::string> examples() {
  std::ifstream document(GECOS_PROTOCOL);
  std::map<std::string, std::string> found;
  std::string* current = nullptr;
  for (std::string line; std::getline(document, line);) {
    constexpr std::string_view fence = "```";
    constexpr std::string_view begin = "```hex ";
    if (line.starts_with(begin)) {
      current = &found[line.substr(begin.size())];
    } else if (line.starts_with(fence)) {
      current = nullptr;
    } else if (current != nullptr) {
      *current += line.substr(0, line.find(' '));
    }
  }
  return found;
}

crypto::Secret<crypto::key_bytes> all_of(int value) {
  crypto::Secret<crypto::key_bytes> secret;
  std::ranges::fill(secret.bytes(), static_cast<std::byte>(value));
  return secret;
}

Bytes joined(std::initializer_list<ByteView> parts) {
  Bytes all;
  for (const ByteView part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

class ProtocolDocument : public testing::Test {
 protected:
  void expect(const std::string& name, ByteView written) {
    const auto found = examples_.find(name);
    ASSERT_NE(found, examples_.end()) << "docs/protocol.md has no example \"" << name << '"';
    EXPECT_EQ(found->second, hex(written)) << name;
  }
  void expect_packet(const std::string& name, wire::PacketHeader header, ByteView body) {
    Bytes packet;
    write_packet(packet, header, body);
    expect(name, packet);
  }

  const std::map<std::string, std::string> examples_ = examples();
};

TEST_F(ProtocolDocument, ShowsTheChannelAsItIsOpened) {
  const crypto::Identity client(crypto::KeyPair::of(all_of(0x11)));
  const crypto::Identity server(crypto::KeyPair::of(all_of(0x22)));
  const std::uint64_t number = 0x0102030405060708;
  const auto header = [&](DatagramKind kind, std::uint16_t reply_port) {
    std::array<std::byte, DatagramHeader::bytes> bytes;
    DatagramHeader{kind, reply_port, number}.write(bytes);
    return bytes;
  };
  using namespace std::string_view_literals;
  expect("ask", joined({std::as_bytes(std::span("LC02\0\0\0\7GWBROKER\0"sv)),
                        header(DatagramKind::Ask, 20001)}));

  const media::SealedAddress place{"lcm", "239.255.76.67", 20017, "GO0123456789abcdef",
                                   std::nullopt};
  const auto first_header = header(DatagramKind::First, 20001);
  const Bytes context = media::handshake_context(place, first_header);
  crypto::IkInitiator initiator(client, server.public_key(), context,
                                crypto::KeyPair::of(all_of(0x33)));
  const Bytes first = initiator.write_first({}).value();
  expect("first", joined({first_header, first}));

  const auto responder = crypto::IkResponder::read_first(server, first, context);
  ASSERT_TRUE(responder);
  const auto answered = responder->write_second({}, crypto::KeyPair::of(all_of(0x44)));
  ASSERT_TRUE(answered);
  expect("second", joined({header(DatagramKind::Second, 0), answered->message}));

  const auto finished = initiator.read_second(answered->message);
  ASSERT_TRUE(finished);
  const auto beat = [&](const crypto::Key& key, std::uint16_t reply_port, std::int64_t sent_ns) {
    const auto clear = header(DatagramKind::Sealed, reply_port);
    Bytes frame(crypto::Sealer::overhead + InnerHeader::bytes);
    InnerHeader{InnerKind::Beat, 0, sent_ns}.write(
        std::span(frame).subspan<crypto::Sealer::text_at, InnerHeader::bytes>());
    crypto::Sealer(key, TimePoint{}).seal(clear, frame);
    return joined({clear, frame});
  };
  expect("client beat", beat(finished->keys.send, 20001, 1'000'000'000));
  expect("server beat", beat(answered->keys.send, 0, 2'000'000'000));
}

TEST_F(ProtocolDocument, ShowsPacketsAsTheyAreWritten) {
  const SessionId session{9};
  Hello hello{"eva", "lab", "demo", 42, 5, "gecos::Broker", 0, std::chrono::milliseconds(750)};
  expect_packet("hello", {.kind = wire::PacketKind::Hello}, wire::to_bytes(hello));

  const Welcome welcome{
      "BROKER", "gecos::Broker", {}, 0x1234, 6, 256, {{BrokerInterface::list.code, 0x77}}};
  expect_packet("welcome", {.kind = wire::PacketKind::Welcome, .session = session},
                wire::to_bytes(welcome));

  const FailureBody refused{"RX90 is a robcl::Rx90, not a gecos::Broker", {}, {}};
  expect_packet(
      "refused",
      {.kind = wire::PacketKind::Refused, .flags = static_cast<std::int8_t>(Detail::Refused)},
      wire::to_bytes(refused));

  expect_packet("call",
                {.kind = wire::PacketKind::Call,
                 .code = BrokerInterface::lookup.code,
                 .session = session,
                 .counter = 3,
                 .acknowledged = 2,
                 .deadline = std::chrono::seconds(2)},
                layout::to_bytes(Broker_lookup_arguments{"RX90"}));

  UnknownName unknown;
  unknown.name = "RX90";
  unknown.known = {"BROKER"};
  Bytes reply;
  write_failure(
      reply, {.kind = wire::PacketKind::Reply, .session = session, .counter = 3},
      {Detail::Fault, "unknown", std::string(UnknownName::type_name()), wire::to_bytes(unknown)});
  expect("reply", reply);

  expect_packet("progress",
                {.kind = wire::PacketKind::Progress,
                 .flags = static_cast<std::int8_t>(Detail::Queued),
                 .session = session,
                 .counter = 3},
                wire::to_bytes(ProgressBody{1, 0, {}}));
  expect_packet("goodbye",
                {.kind = wire::PacketKind::Goodbye, .session = session, .acknowledged = 4}, {});
}

TEST_F(ProtocolDocument, ShowsHowAStatusIsAcquired) {
  const GecosObject_acquire_arguments wanted{gecos::Status::ACTOR, "two hands"};
  expect_packet("acquire",
                {.kind = wire::PacketKind::Call,
                 .code = GecosObjectInterface::acquire.code,
                 .session = SessionId{9},
                 .counter = 4,
                 .acknowledged = 3},
                layout::to_bytes(wanted));
  expect_packet("granted",
                {.kind = wire::PacketKind::Reply,
                 .flags = static_cast<std::int8_t>(Detail::Done),
                 .session = SessionId{9},
                 .counter = 4},
                layout::to_bytes(GecosObject_acquire_result{{gecos::Status::ACTOR, 11}}));
}

TEST_F(ProtocolDocument, ShowsASampleOfAClient) {
  Bytes sample(inward_header_size + sizeof(double));
  write_inward_header(std::span(sample).first<inward_header_size>(), {SessionId{9}, Epoch{11}, 4});
  wire::Encoder(std::span(sample).subspan(inward_header_size)).put(0.25);
  append_measured(sample, TimePoint(std::chrono::seconds(2)));
  expect("inward sample", sample);
}

}  // namespace
}  // namespace gecos::session
