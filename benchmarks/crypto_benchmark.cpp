// Cost of sealing a packet, compared with copying as many bytes, and of opening a channel.
#include <benchmark/benchmark.h>

#include <cstring>

#include "gecos/crypto/handshake_acceptor.hpp"
#include "gecos/crypto/handshake_initiator.hpp"
#include "gecos/crypto/stream_seal.hpp"

namespace {

using gecos::Bytes;
using gecos::TimePoint;
using namespace gecos::crypto;

constexpr std::size_t header_bytes = 16;

SessionKeys some_keys() {
  SessionKeys keys;
  keys.send = keys.receive = Key(KeyPair::draw().secret.bytes());
  return keys;
}

std::size_t size_of(const benchmark::State& state) {
  return static_cast<std::size_t>(state.range(0));
}

void copy(benchmark::State& state) {
  const Bytes from(size_of(state));
  Bytes to(from.size());
  for (auto _ : state) {
    std::memcpy(to.data(), from.data(), from.size());
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(copy)->Arg(64)->Arg(256)->Arg(1400);

void seal(benchmark::State& state) {
  Channel channel({}, some_keys(), TimePoint{});
  const Bytes header(header_bytes);
  Bytes frame(Sealer::overhead + size_of(state));
  for (auto _ : state) channel.out.seal(header, frame);
}
BENCHMARK(seal)->Arg(64)->Arg(256)->Arg(1400);

/// Opening needs a sealed frame each time, so this is both.
void seal_and_open(benchmark::State& state) {
  Channel channel({}, some_keys(), TimePoint{});
  const Bytes header(header_bytes);
  Bytes frame(Sealer::overhead + size_of(state));
  for (auto _ : state) {
    channel.out.seal(header, frame);
    if (!channel.in.open(header, frame)) state.SkipWithError("refused");
  }
}
BENCHMARK(seal_and_open)->Arg(64)->Arg(256)->Arg(1400);

void refuse_forged(benchmark::State& state) {
  Channel channel({}, some_keys(), TimePoint{});
  const Bytes header(header_bytes);
  Bytes frame(Sealer::overhead + size_of(state));
  for (auto _ : state) {
    if (channel.in.open(header, frame)) state.SkipWithError("accepted");
  }
}
BENCHMARK(refuse_forged)->Arg(64)->Arg(1400);

void sign_sample(benchmark::State& state) {
  StreamSealer writer;
  Bytes frame(StreamSealer::overhead + size_of(state));
  for (auto _ : state) writer.seal({}, frame);
}
BENCHMARK(sign_sample)->Arg(64)->Arg(1400);

void sign_and_verify_sample(benchmark::State& state) {
  StreamSealer writer;
  StreamOpener reader(writer.key());
  Bytes frame(StreamSealer::overhead + size_of(state));
  for (auto _ : state) {
    writer.seal({}, frame);
    if (!reader.open({}, frame)) state.SkipWithError("refused");
  }
}
BENCHMARK(sign_and_verify_sample)->Arg(64)->Arg(1400);

void handshake_of_both_sides(benchmark::State& state) {
  const Identity client(KeyPair::draw());
  const Identity server(KeyPair::draw());
  HandshakeAcceptor acceptor(server, [](const PublicKey&) { return true; },
                             {.burst = 4'000'000'000});
  for (auto _ : state) {
    const auto initiator = HandshakeInitiator::begin(client, server.public_key(), {}, {});
    const auto answer = acceptor.answer(initiator->first(), {}, {}, TimePoint{});
    if (!initiator->finish(answer->second, TimePoint{})) state.SkipWithError("refused");
  }
}
BENCHMARK(handshake_of_both_sides);

void refuse_forged_handshake(benchmark::State& state) {
  const Identity server(KeyPair::draw());
  HandshakeAcceptor acceptor(server, [](const PublicKey&) { return true; },
                             {.burst = 4'000'000'000});
  const Bytes noise(IkInitiator::first_overhead, std::byte{9});
  for (auto _ : state) {
    if (acceptor.answer(noise, {}, {}, TimePoint{})) state.SkipWithError("accepted");
  }
}
BENCHMARK(refuse_forged_handshake);

}  // namespace

BENCHMARK_MAIN();
