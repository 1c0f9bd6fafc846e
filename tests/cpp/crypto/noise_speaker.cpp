// Opens a channel over standard input and output, for a peer that is not ours (tests/system).
//
//   noise_speaker initiator <own secret> <peer's public key> <context>
//   noise_speaker responder <own secret> <context>
//
// All in hex, a message a line. Then "seal <text>" answers with a frame, and "open <frame>" with
// its text or "refused". Keys move on after every third packet.
#include <iostream>
#include <string>
#include <vector>

#include "gecos/crypto/handshake_acceptor.hpp"
#include "gecos/crypto/handshake_initiator.hpp"
#include "json.hpp"

namespace {

using gecos::Bytes;
using gecos::ByteView;
using gecos::TimePoint;
using gecos::testing::from_hex;
using gecos::testing::to_hex;
using namespace gecos::crypto;

constexpr RekeyRule rule{.packets = 3};
const std::string greeting = "67726565";

Identity identity_of(const std::string& secret) {
  const Bytes bytes = from_hex(secret);
  return Identity(KeyPair::of(Secret<key_bytes>(std::span<const std::byte, key_bytes>(bytes))));
}

void say(const std::string& line) { std::cout << line << std::endl; }

std::string hear() {
  std::string line;
  std::getline(std::cin, line);
  return line;
}

std::optional<Channel> initiate(const Identity& own, const std::string& peer, ByteView context) {
  const auto initiator =
      HandshakeInitiator::begin(own, PublicKey::parse(peer).value(), context, from_hex(greeting));
  say(to_hex(initiator->first()));
  auto opened = initiator->finish(from_hex(hear()), TimePoint{}, rule);
  if (!opened) return std::nullopt;
  say("peer says " + to_hex(opened->payload));
  return std::move(opened->channel);
}

std::optional<Channel> respond(const Identity& own, ByteView context) {
  HandshakeAcceptor acceptor(
      own, [](const PublicKey&) { return true; }, {}, rule);
  auto answer = acceptor.answer(from_hex(hear()), context, from_hex(greeting), TimePoint{});
  if (!answer) return std::nullopt;
  say(to_hex(answer->second));
  say("peer says " + to_hex(answer->payload));
  return std::move(answer->channel);
}

std::string obey(Channel& channel, const std::string& order, const Bytes& bytes) {
  if (order == "seal") {
    Bytes frame(Sealer::overhead + bytes.size());
    std::ranges::copy(bytes, frame.begin() + Sealer::text_at);
    channel.out.seal({}, frame);
    return to_hex(frame);
  }
  Bytes frame = bytes;
  const auto text = channel.in.open({}, frame);
  return text ? to_hex(*text) : "refused";
}

}  // namespace

int main(int count, char** words) {
  const std::vector<std::string> arguments(words, words + count);
  if (count < 4) return 2;
  const Identity own = identity_of(arguments[2]);
  auto channel = arguments[1] == "initiator" && count == 5
                     ? initiate(own, arguments[3], from_hex(arguments[4]))
                     : respond(own, from_hex(arguments[3]));
  if (!channel) {
    say("refused");
    return 1;
  }
  say("peer is " + channel->peer.to_string() + " binding " + to_hex(channel->binding));
  for (std::string line = hear(); !line.empty(); line = hear()) {
    const auto space = line.find(' ');
    say(obey(*channel, line.substr(0, space), from_hex(line.substr(space + 1))));
  }
}
