#include "gecos/crypto/handshake_acceptor.hpp"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "gecos/crypto/big_endian.hpp"
#include "gecos/crypto/raw.hpp"

namespace gecos::crypto {
namespace {

std::array<std::byte, 16> digest_of(ByteView first, ByteView context) {
  std::array<std::byte, 8> size;
  write_u64(size, context.size());
  crypto_generichash_state state;
  std::array<std::byte, 16> digest;
  ::crypto_generichash_init(&state, nullptr, 0, digest.size());
  for (const ByteView part : {ByteView(size), context, first}) {
    ::crypto_generichash_update(&state, raw(part.data()), part.size());
  }
  ::crypto_generichash_final(&state, raw(digest.data()), digest.size());
  return digest;
}

}  // namespace

std::string_view to_string(Refusal refusal) {
  switch (refusal) {
    case Refusal::Busy:
      return "too many handshakes at a time; try again later";
    case Refusal::Malformed:
      return "the message is not for this server and address, or it was altered";
    case Refusal::NotAdmitted:
      return "the key is not admitted";
    case Refusal::Replayed:
      return "the message is a replay: it was answered long ago";
  }
  return "unknown";
}

HandshakeAcceptor::HandshakeAcceptor(const Identity& own, Admission is_admitted, HandshakeRule rule,
                                     RekeyRule rekey)
    : own_(own),
      is_admitted_(std::move(is_admitted)),
      rule_(rule),
      rekey_(rekey),
      budget_(rule.burst) {
  if (rule.remembered == 0)
    throw std::invalid_argument("HandshakeRule::remembered must be at least 1");
}

tl::expected<HandshakeAcceptor::Answer, HandshakeAcceptor::Refused> HandshakeAcceptor::answer(
    ByteView first, ByteView context, ByteView payload, TimePoint now) {
  const auto refuse = [](Refusal why, std::optional<PublicKey> who = std::nullopt) {
    return tl::unexpected(Refused{why, who});
  };
  forget_answers(now);
  if (first.size() < IkInitiator::first_overhead) return refuse(Refusal::Malformed);
  const Digest digest = digest_of(first, context);
  if (const auto known = known_.find(digest); known != known_.end()) {
    if (known->second.second.empty()) return refuse(Refusal::Replayed);
    return Answer{known->second.second, std::nullopt, {}};
  }
  if (!may_look(now)) return refuse(Refusal::Busy);
  auto responder = IkResponder::read_first(own_, first, context);
  if (!responder) return refuse(Refusal::Malformed);
  const PublicKey peer = responder->initiator();
  if (!is_admitted_(peer)) return refuse(Refusal::NotAdmitted, peer);
  auto finished = responder->write_second(payload);
  if (!finished) return refuse(Refusal::Malformed, peer);
  remember(digest, {now, finished->message});
  return Answer{std::move(finished->message), Channel(peer, finished->keys, now, rekey_),
                responder->payload()};
}

bool HandshakeAcceptor::may_look(TimePoint now) {
  if (budgeted_ && now > *budgeted_) {
    const std::chrono::duration<double> passed = now - *budgeted_;
    budget_ = std::min<double>(rule_.burst, budget_ + passed.count() * rule_.per_second);
  }
  budgeted_ = now;
  if (budget_ < 1) return false;
  budget_ -= 1;
  return true;
}

void HandshakeAcceptor::remember(const Digest& digest, Known known) {
  if (order_.size() == rule_.remembered) {
    known_.erase(order_.front());
    order_.pop_front();
    if (forgotten_ > 0) --forgotten_;
  }
  known_.emplace(digest, std::move(known));
  order_.push_back(digest);
}

void HandshakeAcceptor::forget_answers(TimePoint now) {
  for (; forgotten_ < order_.size(); ++forgotten_) {
    Known& known = known_.at(order_[forgotten_]);
    if (now - known.when < rule_.answers_kept) return;
    Bytes().swap(known.second);
  }
}

}  // namespace gecos::crypto
