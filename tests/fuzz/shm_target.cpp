#include "shm_target.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <memory>
#include <string>

#include "gecos/media/shm/connection.hpp"
#include "gecos/media/shm/stream.hpp"

namespace gecos::fuzz {
namespace {

using namespace gecos::media;
using shm::ControlMessage;
using shm::ControlType;
using shm::ShmConnection;

constexpr std::size_t ring_bytes = RingMemory::bytes(usual_slot_count);
constexpr std::size_t stream_bytes = StreamMemory::bytes(64, 4);

/// The end that is not ours.
class Hostile {
 public:
  /// Its ring is honest at first, and both are.
  static std::unique_ptr<Connection> meet(Hostile& self, bool as_server) {
    std::array<int, 2> ends{};
    expect(
        ::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) == 0,
        "setup: a socket");
    self.socket_ = Descriptor(ends[1]);
    Peer peer{::geteuid(), ::getpid(), "a peer that means harm"};
    const std::array given{self.memory_.memfd.get(), self.event_.descriptor()};
    if (!as_server) {
      auto connection = ShmConnection::greet(Descriptor(ends[0]), peer, {});
      expect(connection.has_value(), "setup: a client");
      shm::send_control(self.socket_.get(), {.type = ControlType::Welcome}, given);
      return std::move(*connection);
    }
    shm::ReceivedControl hello;
    hello.descriptors = {Descriptor(::dup(given[0])), Descriptor(::dup(given[1]))};
    auto connection = ShmConnection::welcome(Descriptor(ends[0]), peer, {}, hello);
    expect(connection.has_value(), "setup: a server");
    return std::move(*connection);
  }

  void act(Script& script) {
    switch (script.below(4)) {
      case 0:
        return scribble(script);
      case 1:
        return offer_packet(script);
      case 2:
        return say(script);
      case 3: {
        const Bytes garbage = script.bytes(255);
        static_cast<void>(
            ::send(socket_.get(), garbage.data(), garbage.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
        return;
      }
    }
  }

 private:
  void scribble(Script& script) {
    const std::uint64_t value = script.number();
    std::memcpy(memory_.mapping.data() + script.word() % (ring_bytes / 8) * 8, &value, 8);
    std::memcpy(memory_.mapping.data() + script.below(32) * 8, &value, 8);  // its control block
  }
  void offer_packet(Script& script) {
    RingSlot& slot = ring_.slots[script.byte() % usual_slot_count];
    slot.size.store(static_cast<std::uint32_t>(script.number()));
    slot.sequence.store(script.one_in(4) ? script.number() : next_);
    next_ += script.below(3);
  }
  void say(Script& script) {
    ControlMessage message{.type = static_cast<ControlType>(script.below(8)), .id = script.byte()};
    if (script.one_in(8)) message.version = static_cast<std::uint32_t>(script.word());
    message.largest = script.one_in(2) ? script.number() : 64;
    message.depth = script.one_in(2) ? script.number() : 4;
    std::array<int, 2> given{stream_.memfd.get(), event_.descriptor()};
    const std::size_t count = script.below(3);
    if (script.one_in(4)) given[0] = memory_.memfd.get();
    if (script.one_in(8)) given[1] = socket_.get();
    shm::send_control(socket_.get(), message, std::span(given).first(count));
    auto* const words = reinterpret_cast<std::uint64_t*>(stream_.mapping.data());
    words[script.byte() % (stream_bytes / 8)] = script.number();
  }

  Descriptor socket_;
  EventFd event_;
  shm::SealedMemory memory_ = shm::make_sealed("hostile", ring_bytes).value();
  shm::SealedMemory stream_ = shm::make_sealed("hostile stream", stream_bytes).value();
  const RingMemory ring_ = RingMemory::at(memory_.mapping.data(), usual_slot_count);
  std::uint64_t next_ = 1;
};

}  // namespace

void try_shm_connection(Script script) {
  const bool as_server = script.one_in(2);
  Hostile hostile;
  const auto connection = Hostile::meet(hostile, as_server);
  auto sealed =
      std::make_shared<shm::SealedMemory>(shm::make_sealed("stream", stream_bytes).value());
  const StreamMemory memory{sealed->mapping.data(), 64, 4};
  shm::SharedStreamWriter writer(memory, std::move(sealed));
  std::unique_ptr<StreamReader> reader;
  StreamSample sample;
  std::uint64_t sent = 0;
  Loss loss = Loss::None;
  for (int step = 0; step < 200 && !script.over(); ++step) {
    switch (script.below(12)) {
      case 0: {
        const auto packet = connection->receive();
        expect(!packet || packet->size() <= largest_ring_packet,
               "no packet is larger than the largest");
        break;
      }
      case 1:
        if (connection->send(Bytes(script.byte()), {})) ++sent;
        break;
      case 2:
        if (connection->prepare_to_sleep()) connection->woke();
        break;
      case 3:
        connection->beat();
        connection->beats_seen();
        break;
      case 4:
        if (as_server) static_cast<void>(connection->share(script.byte(), writer));
        break;
      case 5:
        if (as_server) connection->unshare(script.byte());
        break;
      case 6:
        if (!as_server) reader = connection->open_stream(script.byte());
        break;
      case 7: {
        const std::uint64_t before = sample.sequence;
        if (reader && reader->next(before, sample))
          expect(sample.sequence > before, "a stream goes forward");
        break;
      }
      case 8:
        static_cast<void>(writer.publish(Bytes(script.below(70)), 1));
        break;
      default:
        hostile.act(script);
    }
    expect(connection->taken_by_peer().value_or(0) <= sent,
           "no more packets are taken than were sent");
    expect(loss == Loss::None || connection->loss() == loss, "the first loss stays");
    loss = connection->loss();
    expect((loss == Loss::None) == connection->loss_text().empty(), "a loss says why");
    expect(loss == Loss::None || !connection->prepare_to_sleep(), "nobody sleeps on what is lost");
  }
}

}  // namespace gecos::fuzz
