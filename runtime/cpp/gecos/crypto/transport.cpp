#include "gecos/crypto/transport.hpp"

#include <limits>
#include <stdexcept>

#include "gecos/crypto/big_endian.hpp"

namespace gecos::crypto {
namespace {

constexpr unsigned generation_shift = 32;

std::span<std::byte> text_of(std::span<std::byte> frame) {
  return frame.subspan(Sealer::text_at, frame.size() - Sealer::overhead);
}

}  // namespace

std::string_view to_string(OpenProblem problem) {
  switch (problem) {
    case OpenProblem::TooShort:
      return "the packet is too short for a sealed packet";
    case OpenProblem::Replayed:
      return "the packet was delivered already";
    case OpenProblem::TooOld:
      return "the packet is too old";
    case OpenProblem::TooNew:
      return "the packet is sealed under a key that the peer cannot use yet";
    case OpenProblem::Forged:
      return "the packet is not from the peer, or it was altered";
  }
  return "unknown";
}

Sealer::Sealer(const Key& key, TimePoint now, RekeyRule rule)
    : rule_(rule), key_(key), since_(now) {
  if (rule.packets == 0) throw std::invalid_argument("RekeyRule::packets must be at least 1");
}

void Sealer::seal(ByteView associated, std::span<std::byte> frame) {
  if (frame.size() < overhead)
    throw std::invalid_argument("the frame is too short for counter and tag");
  if (number_ == rule_.packets) next_generation();
  const std::uint64_t counter = std::uint64_t{generation_} << generation_shift | number_;
  ++number_;
  write_u64(frame.first<text_at>(), counter);
  aead_seal(key_, counter, associated, text_of(frame), frame.last<tag_bytes>());
}

void Sealer::on_tick(TimePoint now) {
  if (now - since_ < rule_.after) return;
  since_ = now;
  if (number_ != 0) next_generation();  // an unused key need not be replaced
}

void Sealer::next_generation() {
  if (generation_ == std::numeric_limits<std::uint32_t>::max()) {
    throw std::length_error("this channel has used all its keys: open a new channel");
  }
  key_ = next_key(key_);
  ++generation_;
  number_ = 0;
}

Opener::Opener(const Key& key) { current_.key = key; }

tl::expected<std::span<std::byte>, OpenProblem> Opener::open(ByteView associated,
                                                             std::span<std::byte> frame) {
  if (frame.size() < Sealer::overhead) return tl::unexpected(OpenProblem::TooShort);
  const std::uint64_t counter = read_u64(frame.first<Sealer::text_at>());
  const auto generation = static_cast<std::uint32_t>(counter >> generation_shift);
  if (generation == current_.number) return open_with(current_, counter, associated, frame);
  if (generation > current_.number) return open_newer(counter, associated, frame);
  if (previous_ && generation == previous_->number) {
    return open_with(*previous_, counter, associated, frame);
  }
  return tl::unexpected(OpenProblem::TooOld);
}

tl::expected<std::span<std::byte>, OpenProblem> Opener::open_with(Generation& generation,
                                                                  std::uint64_t counter,
                                                                  ByteView associated,
                                                                  std::span<std::byte> frame) {
  const auto number = static_cast<std::uint32_t>(counter);
  if (generation.seen.too_old(number)) return tl::unexpected(OpenProblem::TooOld);
  if (!generation.seen.fresh(number)) return tl::unexpected(OpenProblem::Replayed);
  const auto text = text_of(frame);
  if (!aead_open(generation.key, counter, associated, text, frame.last<tag_bytes>())) {
    return tl::unexpected(OpenProblem::Forged);
  }
  generation.seen.mark(number);
  opened_any_ = true;
  return text;
}

tl::expected<std::span<std::byte>, OpenProblem> Opener::open_newer(std::uint64_t counter,
                                                                   ByteView associated,
                                                                   std::span<std::byte> frame) {
  const auto generation = static_cast<std::uint32_t>(counter >> generation_shift);
  const std::uint32_t steps = generation - current_.number;
  if (steps > most_lost_generations) return tl::unexpected(OpenProblem::TooNew);
  Generation next{generation, current_.key, {}};
  for (std::uint32_t i = 0; i < steps; ++i) next.key = next_key(next.key);
  const auto text = open_with(next, counter, associated, frame);
  if (!text) return text;
  previous_ = current_;
  previous_since_.reset();
  current_ = next;
  return text;
}

void Opener::on_tick(TimePoint now) {
  if (!previous_) return;
  if (!previous_since_) {
    previous_since_ = now;
  } else if (now - *previous_since_ >= previous_kept) {
    previous_.reset();
  }
}

}  // namespace gecos::crypto
