#include "gecos/wire/swap_copy.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#define GECOS_SWAP_X86 1
#include <immintrin.h>
#else
#define GECOS_SWAP_X86 0
#endif

namespace gecos::wire::detail {
namespace {

using SwapCopy = void (*)(std::byte* to, const std::byte* from, std::size_t count);

struct SwapLoops {
  SwapCopy of_16;
  SwapCopy of_32;
  SwapCopy of_64;
};

constexpr SwapLoops portable_loops{swap_copy_portable<2>, swap_copy_portable<4>,
                                   swap_copy_portable<8>};

#if GECOS_SWAP_X86

// Shuffle masks: where byte i of each 16-byte lane comes from.
template <std::size_t width>
__attribute__((target("ssse3"))) inline __m128i reversal() {
  if constexpr (width == 2) {
    return _mm_set_epi8(14, 15, 12, 13, 10, 11, 8, 9, 6, 7, 4, 5, 2, 3, 0, 1);
  } else if constexpr (width == 4) {
    return _mm_set_epi8(12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3);
  } else {
    return _mm_set_epi8(8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7);
  }
}

template <std::size_t width>
__attribute__((target("ssse3"))) void swap_copy_ssse3(std::byte* to, const std::byte* from,
                                                      std::size_t count) {
  constexpr std::size_t step = sizeof(__m128i) / width;
  const __m128i mask = reversal<width>();
  std::size_t done = 0;
  for (; count - done >= step; done += step) {
    const auto* source = reinterpret_cast<const __m128i*>(from + done * width);
    auto* target = reinterpret_cast<__m128i*>(to + done * width);
    _mm_storeu_si128(target, _mm_shuffle_epi8(_mm_loadu_si128(source), mask));
  }
  swap_copy_portable<width>(to + done * width, from + done * width, count - done);
}

template <std::size_t width>
__attribute__((target("avx2"))) void swap_copy_avx2(std::byte* to, const std::byte* from,
                                                    std::size_t count) {
  constexpr std::size_t step = 2 * sizeof(__m256i) / width;  // two at a time hides the latency
  const __m256i mask = _mm256_broadcastsi128_si256(reversal<width>());
  std::size_t done = 0;
  for (; count - done >= step; done += step) {
    const auto* source = reinterpret_cast<const __m256i*>(from + done * width);
    auto* target = reinterpret_cast<__m256i*>(to + done * width);
    const __m256i first = _mm256_loadu_si256(source);
    const __m256i second = _mm256_loadu_si256(source + 1);
    _mm256_storeu_si256(target, _mm256_shuffle_epi8(first, mask));
    _mm256_storeu_si256(target + 1, _mm256_shuffle_epi8(second, mask));
  }
  swap_copy_portable<width>(to + done * width, from + done * width, count - done);
}

constexpr SwapLoops ssse3_loops{swap_copy_ssse3<2>, swap_copy_ssse3<4>, swap_copy_ssse3<8>};
constexpr SwapLoops avx2_loops{swap_copy_avx2<2>, swap_copy_avx2<4>, swap_copy_avx2<8>};

#endif

const SwapLoops* loops_of(SwapKind kind) {
#if GECOS_SWAP_X86
  __builtin_cpu_init();
  if (kind == SwapKind::Avx2 && __builtin_cpu_supports("avx2")) return &avx2_loops;
  if (kind == SwapKind::Ssse3 && __builtin_cpu_supports("ssse3")) return &ssse3_loops;
#endif
  return kind == SwapKind::Portable ? &portable_loops : nullptr;
}

const SwapLoops& best_loops() {
  static const SwapLoops& best = []() -> const SwapLoops& {
    if (const SwapLoops* loops = loops_of(SwapKind::Avx2)) return *loops;
    if (const SwapLoops* loops = loops_of(SwapKind::Ssse3)) return *loops;
    return portable_loops;
  }();
  return best;
}

}  // namespace

bool swap_copy_with(SwapKind kind, std::size_t width, std::byte* to, const std::byte* from,
                    std::size_t count) {
  const SwapLoops* loops = loops_of(kind);
  if (loops == nullptr) return false;
  (width == 2 ? loops->of_16 : width == 4 ? loops->of_32 : loops->of_64)(to, from, count);
  return true;
}

void swap_copy_16(std::byte* to, const std::byte* from, std::size_t count) {
  best_loops().of_16(to, from, count);
}

void swap_copy_32(std::byte* to, const std::byte* from, std::size_t count) {
  best_loops().of_32(to, from, count);
}

void swap_copy_64(std::byte* to, const std::byte* from, std::size_t count) {
  best_loops().of_64(to, from, count);
}

}  // namespace gecos::wire::detail
