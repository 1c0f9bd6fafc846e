// Copies numbers and converts them between the byte order of the host and the big-endian order of
// encoded values. The same functions convert in both directions.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace gecos::wire {

namespace detail {

inline std::uint8_t reversed(std::uint8_t bits) { return bits; }
inline std::uint16_t reversed(std::uint16_t bits) { return __builtin_bswap16(bits); }
inline std::uint32_t reversed(std::uint32_t bits) { return __builtin_bswap32(bits); }
inline std::uint64_t reversed(std::uint64_t bits) { return __builtin_bswap64(bits); }

template <std::size_t width>
struct BitsOf;
template <>
struct BitsOf<1> {
  using type = std::uint8_t;
};
template <>
struct BitsOf<2> {
  using type = std::uint16_t;
};
template <>
struct BitsOf<4> {
  using type = std::uint32_t;
};
template <>
struct BitsOf<8> {
  using type = std::uint64_t;
};

template <std::size_t width>
inline void swap_copy_portable(std::byte* to, const std::byte* from, std::size_t count) {
  typename BitsOf<width>::type bits;
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(&bits, from + i * width, width);
    bits = reversed(bits);
    std::memcpy(to + i * width, &bits, width);
  }
}

enum class SwapKind { Portable, Ssse3, Avx2, Avx512 };

// Copies numbers with the loop `kind`, so that tests and benchmarks can compare the loops. Returns
// false when this processor does not support the loop. `width` is 2, 4 or 8. The host must be
// little-endian.
bool swap_copy_with(SwapKind kind, std::size_t width, std::byte* to, const std::byte* from,
                    std::size_t count);

// swap_copy_16, swap_copy_32 and swap_copy_64 copy numbers with the fastest loop that this
// processor supports. The first call chooses the loop.
void swap_copy_16(std::byte* to, const std::byte* from, std::size_t count);
void swap_copy_32(std::byte* to, const std::byte* from, std::size_t count);
void swap_copy_64(std::byte* to, const std::byte* from, std::size_t count);

}  // namespace detail

/// The minimum number of elements for which a swapping function is called. Fewer elements are
/// swapped inline, because the function call would take longer.
inline constexpr std::size_t swap_inline_below = 16;

/// Copies `count` elements of `width` bytes. On a little-endian host, reverses the bytes of each
/// element. The memory may have any alignment, but source and destination must not overlap.
template <std::size_t width>
inline void swap_copy(std::byte* to, const std::byte* from, std::size_t count) {
  if constexpr (width == 1 || std::endian::native == std::endian::big) {
    if (count != 0) std::memcpy(to, from, count * width);
  } else if (count < swap_inline_below) {
    detail::swap_copy_portable<width>(to, from, count);
  } else if constexpr (width == 2) {
    detail::swap_copy_16(to, from, count);
  } else if constexpr (width == 4) {
    detail::swap_copy_32(to, from, count);
  } else {
    static_assert(width == 8, "numbers on the wire have 1, 2, 4 or 8 bytes");
    detail::swap_copy_64(to, from, count);
  }
}

/// A type of number that can be encoded: an integer or floating-point type of 1 to 8 bytes, or
/// std::byte, but not bool.
template <typename T>
concept Number = (std::integral<T> || std::floating_point<T> ||
                  std::same_as<T, std::byte>)&&!std::same_as<T, bool> &&
                 sizeof(T) <= 8;

template <Number T>
inline void store_big_endian(std::byte* to, T value) {
  auto bits = std::bit_cast<typename detail::BitsOf<sizeof(T)>::type>(value);
  if constexpr (std::endian::native == std::endian::little) bits = detail::reversed(bits);
  std::memcpy(to, &bits, sizeof bits);
}

template <Number T>
inline T load_big_endian(const std::byte* from) {
  typename detail::BitsOf<sizeof(T)>::type bits;
  std::memcpy(&bits, from, sizeof bits);
  if constexpr (std::endian::native == std::endian::little) bits = detail::reversed(bits);
  return std::bit_cast<T>(bits);
}

}  // namespace gecos::wire
