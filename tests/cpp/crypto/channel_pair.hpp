// Both ends of a channel, and packets on their way between them.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "gecos/crypto/handshake_acceptor.hpp"
#include "gecos/crypto/handshake_initiator.hpp"

namespace gecos::testing {

inline Bytes bytes_of(std::string_view text) {
  Bytes bytes(text.size());
  std::ranges::transform(text, bytes.begin(), [](char c) { return std::byte(c); });
  return bytes;
}

inline std::string text_of(ByteView bytes) {
  std::string text(bytes.size(), '\0');
  std::ranges::transform(bytes, text.begin(), [](std::byte b) { return static_cast<char>(b); });
  return text;
}

inline Bytes sealed(crypto::Sealer& sealer, std::string_view text, ByteView associated = {}) {
  Bytes frame(crypto::Sealer::overhead + text.size());
  std::ranges::copy(bytes_of(text), frame.begin() + crypto::Sealer::text_at);
  sealer.seal(associated, frame);
  return frame;
}

/// What is opened, or "refused: …". Takes a copy, so that a frame can come twice.
inline std::string opened(crypto::Opener& opener, Bytes frame, ByteView associated = {}) {
  const auto text = opener.open(associated, frame);
  return text ? text_of(*text) : "refused: " + std::string(to_string(text.error()));
}

/// A client's and a server's end, opened with each other.
struct ChannelPair {
  crypto::Channel client;
  crypto::Channel server;
};

inline constexpr TimePoint pair_opened{std::chrono::hours{1}};

inline ChannelPair open_pair(crypto::RekeyRule rule = {}) {
  const crypto::Identity client(crypto::KeyPair::draw());
  const crypto::Identity server(crypto::KeyPair::draw());
  const auto initiator = crypto::HandshakeInitiator::begin(client, server.public_key(), {}, {});
  crypto::HandshakeAcceptor acceptor(
      server, [](const auto&) { return true; }, {}, rule);
  auto answer = acceptor.answer(initiator->first(), {}, {}, pair_opened);
  auto opened = initiator->finish(answer->second, pair_opened, rule);
  return {std::move(opened->channel), std::move(*answer->channel)};
}

}  // namespace gecos::testing
