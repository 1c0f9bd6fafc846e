// libFuzzer's entry: any bytes to the decoders of packets, frames and generated types. The first
// byte chooses which. What is accepted must be read again from what it encodes to, and no decoder
// may take more memory than its bound.
#include <sanitizer/allocator_interface.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>

#include "cases.hpp"
#include "gecos/wire/packet.hpp"

namespace {

constexpr double allowance = 64 * 1024;

std::size_t live = 0;
std::size_t peak = 0;
std::size_t peak_of_decoding = 0;

void allocated(const volatile void*, std::size_t size) {
  live += size;
  peak = std::max(peak, live);
}

void freed(const volatile void* block) {
  // Freed but never seen allocated: from before the hooks were there.
  live -= std::min(live, __sanitizer_get_allocated_size(const_cast<const void*>(block)));
}

void expect(bool holds, const char* what, const char* type) {
  if (holds) return;
  std::fprintf(stderr, "decoder_fuzzer: %s: %s\n", type, what);
  std::abort();
}

void try_packet(gecos::ByteView bytes) {
  const auto packet = gecos::wire::decode_packet(bytes);
  if (!packet) return;
  const gecos::Bytes again = gecos::wire::encode_packet(packet->header, packet->body, packet->tag);
  const auto same = gecos::wire::decode_packet(again);
  expect(same && same->header == packet->header, "its header is not read again", "packet");
  expect(std::ranges::equal(same->body, packet->body), "its body is not read again", "packet");
  expect(std::ranges::equal(same->tag, packet->tag), "its tag is not read again", "packet");
}

void try_type(const JudgedType& type, gecos::ByteView bytes) {
  const std::size_t before = peak = live;
  const Verdict verdict = judge(type.name, bytes, [] { peak_of_decoding = peak; });
  const double most = type.memory_factor * static_cast<double>(bytes.size()) + allowance;
  expect(static_cast<double>(peak_of_decoding - before) <= most, "too much memory", type.name);
  if (!verdict.bytes) {
    expect(!verdict.why.empty(), "refused without a reason", type.name);
    return;
  }
  const Verdict again = judge(type.name, *verdict.bytes);
  expect(again.bytes.has_value(), "refuses what it encodes", type.name);
  expect(*again.bytes == *verdict.bytes, "encodes otherwise the second time", type.name);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  expect(__sanitizer_install_malloc_and_free_hooks(allocated, freed) != 0, "no hooks", "setup");
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t choice = data[0] % (judged_types().size() + 1);
  const gecos::ByteView bytes = std::as_bytes(std::span(data + 1, size - 1));
  if (choice == 0) {
    try_packet(bytes);
  } else {
    try_type(judged_types()[choice - 1], bytes);
  }
  return 0;
}
