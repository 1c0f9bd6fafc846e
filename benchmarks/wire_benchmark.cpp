// Cost of the codec, compared with memcpy of as many bytes. Compare ratios within one run.
#include <benchmark/benchmark.h>

#include <array>
#include <cstring>
#include <numeric>
#include <string>
#include <vector>

#include "gecos/wire/contents.hpp"
#include "gecos/wire/packet.hpp"

namespace {

using gecos::Bytes;
using gecos::ByteView;
using gecos::wire::Decoder;
using gecos::wire::Encoder;

/// The pose of the measured peers: six doubles, a stamp and sixteen characters.
struct Pose {
  std::int64_t stamp = 0;
  std::array<double, 6> numbers{};
  std::string name;

  std::size_t encoded_size() const { return 8 + 6 * 8 + gecos::wire::string_size(name); }

  void encode(Encoder& to) const {
    to.put(stamp);
    to.put_array(numbers);
    to.put_string(name);
  }

  bool decode(Decoder& from) {
    return from.get(stamp, "stamp") && from.get_array(numbers, "numbers") &&
           from.get_string(name, 64, "name");
  }
};

const Pose pose{1'700'000'000'000'000'000, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6}, "0123456789abcdef"};

Bytes encoded_pose() {
  Bytes bytes(pose.encoded_size());
  Encoder to(bytes);
  pose.encode(to);
  return bytes;
}

void copy_pose(benchmark::State& state) {
  const Bytes from = encoded_pose();
  Bytes to(from.size());
  for (auto _ : state) {
    std::memcpy(to.data(), from.data(), from.size());
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(copy_pose);

void encode_pose(benchmark::State& state) {
  Bytes bytes(pose.encoded_size());
  Pose value = pose;
  for (auto _ : state) {
    benchmark::DoNotOptimize(value);
    Encoder to(bytes);
    value.encode(to);
    benchmark::DoNotOptimize(bytes.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(encode_pose);

void decode_pose(benchmark::State& state) {
  const Bytes bytes = encoded_pose();
  Pose value;
  for (auto _ : state) {
    Decoder from(bytes);
    bool decoded = value.decode(from) && from.expect_end();
    benchmark::DoNotOptimize(decoded);
    benchmark::DoNotOptimize(value);
  }
}
BENCHMARK(decode_pose);

/// Runs `copy(to, from, count)` on a thousand doubles, `shift` bytes off alignment.
template <typename Copy>
void thousand_doubles(benchmark::State& state, Copy copy) {
  constexpr std::size_t count = 1000;
  const auto shift = static_cast<std::size_t>(state.range(0));
  std::vector<double> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0.5);
  Bytes bytes(count * sizeof(double) + 64);
  const auto* from = reinterpret_cast<const std::byte*>(numbers.data());
  for (auto _ : state) {
    copy(bytes.data() + shift, from, count);
    benchmark::DoNotOptimize(bytes.data());
    benchmark::ClobberMemory();
  }
}

void copy_1000(benchmark::State& state) {
  thousand_doubles(state, [](std::byte* to, const std::byte* from, std::size_t count) {
    std::memcpy(to, from, count * sizeof(double));
  });
}
BENCHMARK(copy_1000)->Arg(0)->Arg(4);

void swap_1000(benchmark::State& state) {
  thousand_doubles(state, gecos::wire::swap_copy<sizeof(double)>);
}
BENCHMARK(swap_1000)->Arg(0)->Arg(4);

template <gecos::wire::detail::SwapKind kind>
void swap_1000_with(benchmark::State& state) {
  using gecos::wire::detail::swap_copy_with;
  if (!swap_copy_with(kind, sizeof(double), nullptr, nullptr, 0)) {
    state.SkipWithError("this machine does not have it");
    return;
  }
  thousand_doubles(state, [](std::byte* to, const std::byte* from, std::size_t count) {
    swap_copy_with(kind, sizeof(double), to, from, count);
  });
}
BENCHMARK_TEMPLATE(swap_1000_with, gecos::wire::detail::SwapKind::Portable)->Arg(0)->Arg(4);
BENCHMARK_TEMPLATE(swap_1000_with, gecos::wire::detail::SwapKind::Ssse3)->Arg(0)->Arg(4);
BENCHMARK_TEMPLATE(swap_1000_with, gecos::wire::detail::SwapKind::Avx2)->Arg(0)->Arg(4);
BENCHMARK_TEMPLATE(swap_1000_with, gecos::wire::detail::SwapKind::Avx512)->Arg(0)->Arg(4);

const gecos::wire::PacketHeader call{.kind = gecos::wire::PacketKind::Call,
                                     .code = gecos::FunctionCode{0x12345678},
                                     .session = gecos::SessionId{7},
                                     .counter = 1'000'000};

void encode_packet_head(benchmark::State& state) {
  std::array<std::byte, gecos::wire::packet_head_size> head;
  gecos::wire::PacketHeader header = call;
  for (auto _ : state) {
    benchmark::DoNotOptimize(header);
    gecos::wire::encode_packet_head(head, header, 64);
    benchmark::DoNotOptimize(head);
  }
}
BENCHMARK(encode_packet_head);

void decode_packet(benchmark::State& state) {
  const Bytes bytes = gecos::wire::encode_packet(call, Bytes(64));
  ByteView view = bytes;
  for (auto _ : state) {
    benchmark::DoNotOptimize(view);
    auto packet = gecos::wire::decode_packet(view);
    benchmark::DoNotOptimize(packet);
  }
}
BENCHMARK(decode_packet);

}  // namespace

BENCHMARK_MAIN();
