#include "gecos/wire/swap_copy.hpp"

#if defined(__x86_64__) && defined(__GNUC__)
#define GECOS_SWAP_X86 1
#include <immintrin.h>

#include <initializer_list>
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

// Returns the mask of a shuffle that reverses the bytes of each number. Element i of the mask is
// the index of the byte, in each group of 16 bytes, that moves to position i.
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
  // Each iteration handles four registers and advances the pointers, so that a register needs only
  // two instructions.
  constexpr std::size_t step = 4 * sizeof(__m256i) / width;
  const __m256i mask = _mm256_broadcastsi128_si256(reversal<width>());
  const std::byte* const end = from + count / step * step * width;
  for (; from != end; from += step * width, to += step * width) {
    const auto* source = reinterpret_cast<const __m256i*>(from);
    auto* target = reinterpret_cast<__m256i*>(to);
    const __m256i first = _mm256_shuffle_epi8(_mm256_loadu_si256(source), mask);
    const __m256i second = _mm256_shuffle_epi8(_mm256_loadu_si256(source + 1), mask);
    const __m256i third = _mm256_shuffle_epi8(_mm256_loadu_si256(source + 2), mask);
    const __m256i fourth = _mm256_shuffle_epi8(_mm256_loadu_si256(source + 3), mask);
    _mm256_storeu_si256(target, first);
    _mm256_storeu_si256(target + 1, second);
    _mm256_storeu_si256(target + 2, third);
    _mm256_storeu_si256(target + 3, fourth);
  }
  swap_copy_ssse3<width>(to, from, count % step);
}

template <std::size_t width>
__attribute__((target("avx512bw"))) void swap_copy_avx512(std::byte* to, const std::byte* from,
                                                          std::size_t count) {
  constexpr std::size_t step = 2 * sizeof(__m512i) / width;
  const __m512i mask = _mm512_maskz_broadcast_i32x4(0xFFFF, reversal<width>());
  const std::byte* const end = from + count / step * step * width;
  for (; from != end; from += step * width, to += step * width) {
    const __m512i first = _mm512_shuffle_epi8(_mm512_loadu_si512(from), mask);
    const __m512i second = _mm512_shuffle_epi8(_mm512_loadu_si512(from + sizeof first), mask);
    _mm512_storeu_si512(to, first);
    _mm512_storeu_si512(to + sizeof first, second);
  }
  swap_copy_ssse3<width>(to, from, count % step);
}

constexpr SwapLoops ssse3_loops{swap_copy_ssse3<2>, swap_copy_ssse3<4>, swap_copy_ssse3<8>};
constexpr SwapLoops avx2_loops{swap_copy_avx2<2>, swap_copy_avx2<4>, swap_copy_avx2<8>};
constexpr SwapLoops avx512_loops{swap_copy_avx512<2>, swap_copy_avx512<4>, swap_copy_avx512<8>};

#endif

const SwapLoops* loops_of(SwapKind kind) {
#if GECOS_SWAP_X86
  __builtin_cpu_init();
  if (kind == SwapKind::Avx512 && __builtin_cpu_supports("avx512bw")) return &avx512_loops;
  if (kind == SwapKind::Avx2 && __builtin_cpu_supports("avx2")) return &avx2_loops;
  if (kind == SwapKind::Ssse3 && __builtin_cpu_supports("ssse3")) return &ssse3_loops;
#endif
  return kind == SwapKind::Portable ? &portable_loops : nullptr;
}

const SwapLoops& best_loops() {
  static const SwapLoops& best = []() -> const SwapLoops& {
    for (const SwapKind kind : {SwapKind::Avx512, SwapKind::Avx2, SwapKind::Ssse3}) {
      if (const SwapLoops* loops = loops_of(kind)) return *loops;
    }
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
