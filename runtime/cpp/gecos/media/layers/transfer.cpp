#include "gecos/media/layers/transfer.hpp"

#include <algorithm>
#include <utility>

namespace gecos::media {
namespace {

constexpr std::uint64_t piece_mark = 0x6765636f73207031;     // "gecos p1"
constexpr std::uint64_t received_mark = 0x6765636f73206131;  // "gecos a1"
constexpr std::uint32_t bits_beyond = 32;

template <class T>
std::byte* put(std::byte* to, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    to[i] = static_cast<std::byte>(value >> (8 * (sizeof(T) - 1 - i)));
  }
  return to + sizeof(T);
}

template <class T>
T get(ByteView from, std::size_t at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value = static_cast<T>(value << 8) | std::to_integer<T>(from[at + i]);
  }
  return value;
}

std::uint32_t pieces_of(std::size_t size, std::size_t piece_bytes) {
  return static_cast<std::uint32_t>((size + piece_bytes - 1) / piece_bytes);
}

}  // namespace

void Piece::write_head(std::span<std::byte, head_bytes> to) const {
  put(put(put(put(to.data(), piece_mark), transfer), size), index);
}

std::optional<Piece> Piece::read(ByteView packet, std::size_t piece_bytes) {
  if (packet.size() < head_bytes || get<std::uint64_t>(packet, 0) != piece_mark)
    return std::nullopt;
  const Piece piece{get<std::uint64_t>(packet, 8), get<std::uint32_t>(packet, 16),
                    get<std::uint32_t>(packet, 20), packet.subspan(head_bytes)};
  if (piece.transfer == 0 || piece.size == 0 || piece.size > largest_transfer ||
      piece.index >= pieces_of(piece.size, piece_bytes)) {
    return std::nullopt;
  }
  const std::size_t before = std::size_t{piece.index} * piece_bytes;
  if (piece.content.size() != std::min(piece_bytes, piece.size - before)) return std::nullopt;
  return piece;
}

void Received::write(std::span<std::byte, bytes> to) const {
  put(put(put(put(to.data(), received_mark), transfer), all_before), beyond);
}

std::optional<Received> Received::read(ByteView packet) {
  if (packet.size() != bytes || get<std::uint64_t>(packet, 0) != received_mark) return std::nullopt;
  return Received{get<std::uint64_t>(packet, 8), get<std::uint32_t>(packet, 16),
                  get<std::uint32_t>(packet, 20)};
}

OutgoingTransfer::OutgoingTransfer(std::uint64_t number, Bytes packet, std::size_t piece_bytes)
    : number_(number),
      packet_(std::move(packet)),
      piece_bytes_(piece_bytes),
      pieces_(pieces_of(packet_.size(), piece_bytes)) {}

void OutgoingTransfer::advance(TimePoint now, FunctionRef<void(const Piece&)> send) {
  const bool silent = sendings_ != 0 && now - last_word_ >= silence;
  if (sendings_ == 0 || silent) last_word_ = now;
  const auto end = std::min<std::size_t>(pieces_.size(), std::size_t{all_before_} + window);
  for (std::size_t index = all_before_; index < end; ++index) {
    State& piece = pieces_[index];
    const bool lost = silent || piece.sent_as + reordering_threshold <= newest_arrived_;
    if (piece.arrived || (piece.sent_as != 0 && !lost)) continue;
    piece.sent_as = ++sendings_;
    const std::size_t at = index * piece_bytes_;
    send({number_, static_cast<std::uint32_t>(packet_.size()), static_cast<std::uint32_t>(index),
          ByteView(packet_).subspan(at, std::min(piece_bytes_, packet_.size() - at))});
  }
}

void OutgoingTransfer::take(const Received& received, TimePoint now) {
  if (received.transfer != number_ || received.all_before > pieces_.size()) return;
  last_word_ = now;
  const auto note = [&](std::size_t index) {
    State& piece = pieces_[index];
    if (std::exchange(piece.arrived, true)) return;
    newest_arrived_ = std::max(newest_arrived_, piece.sent_as);
  };
  for (std::size_t index = all_before_; index < received.all_before; ++index) note(index);
  for (std::uint32_t bit = 0; bit < bits_beyond; ++bit) {
    const std::size_t index = std::size_t{received.all_before} + 1 + bit;
    if ((received.beyond >> bit & 1) != 0 && index < pieces_.size()) note(index);
  }
  all_before_ = std::max(all_before_, received.all_before);
}

Received IncomingTransfers::take(const Piece& piece) {
  if (piece.transfer > number_) {
    number_ = piece.transfer;
    missing_ = pieces_of(piece.size, piece_bytes_);
    all_before_ = 0;
    arrived_.assign(missing_, false);
    packet_.assign(piece.size, std::byte{0});
    ready_ = false;
  }
  // The piece belongs to an older packet, which is complete, because the peer sends one packet at a
  // time.
  if (piece.transfer < number_) return {piece.transfer, pieces_of(piece.size, piece_bytes_), 0};
  if (missing_ != 0 && piece.size == packet_.size() && !arrived_[piece.index]) {
    arrived_[piece.index] = true;
    const std::size_t at = piece.index * piece_bytes_;
    std::ranges::copy(piece.content, packet_.begin() + static_cast<std::ptrdiff_t>(at));
    ready_ = --missing_ == 0;
  }
  while (all_before_ < arrived_.size() && arrived_[all_before_]) ++all_before_;
  Received received{number_, all_before_, 0};
  for (std::uint32_t bit = 0; bit < bits_beyond; ++bit) {
    const std::size_t index = std::size_t{all_before_} + 1 + bit;
    if (index < arrived_.size() && arrived_[index]) received.beyond |= std::uint32_t{1} << bit;
  }
  return received;
}

std::optional<Bytes> IncomingTransfers::whole() {
  if (!std::exchange(ready_, false)) return std::nullopt;
  return std::exchange(packet_, {});
}

}  // namespace gecos::media
