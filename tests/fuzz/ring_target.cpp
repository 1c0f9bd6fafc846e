// Rings and streams in memory that the other side scribbles over. The memory is of the heap and
// just as large as it has to be, so that AddressSanitizer sees a byte that is read or written
// beside it.
#include <cstring>
#include <deque>
#include <memory>
#include <new>

#include "gecos/media/buffers/ring.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "script.hpp"
#include "shm_target.hpp"
#include "targets.hpp"

namespace gecos::fuzz {
namespace {

using namespace gecos::media;

class Memory {
 public:
  explicit Memory(std::size_t size) : data_(new (alignment) std::byte[size]) {
    std::memset(data_, 0, size);
  }
  ~Memory() { ::operator delete[](data_, alignment); }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  std::byte* data() const { return data_; }

 private:
  static constexpr std::align_val_t alignment{4096};
  std::byte* const data_;
};

/// What packet or sample `number` says, so that it is known again.
Bytes content(std::uint64_t number, std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(number * 31 + i);
  return bytes;
}

constexpr std::size_t few_slots = 512;  // as few as the largest packet needs

std::size_t slots_for(std::size_t size) {
  return std::max<std::size_t>(1, (size + slot_payload - 1) / slot_payload);
}

/// One direction of a line. One of its sides is honest to the end, the other as long as it likes.
class Ring {
 public:
  explicit Ring(bool hostile_writer) : hostile_writer_(hostile_writer) {
    writer_.set_reader(readers_.control);
  }
  void run(Script script) {
    for (int step = 0; step < 300 && !script.over(); ++step) {
      switch (script.below(6)) {
        case 0:
        case 1:
          write(script.one_in(4) ? script.word() % (largest_ring_packet + 2)
                                 : script.number() % 600);
          break;
        case 2:
        case 3:
          read();
          break;
        case 4:
          hostile_writer_ ? scribble_beside(script) : say_what_is_true();
          break;
        case 5:
          hostile_writer_ ? scribble(script) : lie(script);
          break;
      }
      expect(writer_.taken() <= written_, "no more packets are taken than were sent");
    }
  }

 private:
  struct Sent {
    std::uint64_t number;
    std::size_t size;
  };

  void write(std::size_t size) {
    const Bytes packet = content(written_ + 1, size);
    const auto sent =
        writer_.write(ByteView(packet).first(size / 3), ByteView(packet).subspan(size / 3));
    const bool fits = size <= largest_ring_packet;
    if (!sent) {
      expect((sent.error() == SendProblem::TooLarge) == !fits, "only what never fits is too large");
      expect(!fits || dishonest_ || used_ + slots_for(size) > few_slots, "room is used");
      return;
    }
    expect(fits && *sent == ++written_, "packets are numbered as they are sent");
    used_ += slots_for(size);
    expect(dishonest_ || used_ <= few_slots, "nothing is written over that was not read");
    sent_.push_back({written_, size});
  }

  /// The honest reader, or what a hostile one does before it lies.
  void read() {
    if (dishonest_ && !hostile_writer_) return;
    const RingSlot& next = writers_.slots[position_ % few_slots];
    const bool there = next.sequence.load() == position_ + 1;
    const bool impossible = there && next.size.load() > largest_ring_packet;
    const bool was_broken = reader_.broken();
    const auto packet = reader_.read();
    expect(packet.has_value() == (there && !impossible && !was_broken), "what is there is read");
    expect(reader_.broken() == (impossible || was_broken), "an impossible size breaks the ring");
    if (!packet) return expect(dishonest_ || sent_.empty(), "what was sent arrives");
    expect(packet->size() <= largest_ring_packet, "no packet is larger than the largest");
    position_ += slots_for(packet->size());
    expect(readers_.control->slots_taken.load() == position_, "the reader tells how far it is");
    expect(readers_.control->packets_taken.load() == ++read_, "the reader tells what it took");
    if (dishonest_) return;
    expect(!sent_.empty(), "nothing arrives that was not sent");
    const Sent sent = sent_.front();
    sent_.pop_front();
    used_ -= slots_for(sent.size);
    const Bytes expected = content(sent.number, sent.size);
    expect(std::ranges::equal(*packet, expected), "what arrives is what was sent");
  }

  /// Where nothing is under way, it harms nobody: what was sent still arrives.
  void scribble_beside(Script& script) {
    if (dishonest_ || used_ == few_slots) return;
    const std::size_t slot = (position_ + used_ + script.byte() % (few_slots - used_)) % few_slots;
    auto* const bytes = reinterpret_cast<std::byte*>(&writers_.slots[slot]);
    const std::uint64_t value = script.number();
    const std::size_t at = 8 + 8 * script.below(31);
    std::memcpy(bytes + at, &value, 8);
  }
  void scribble(Script& script) {
    dishonest_ = true;
    const std::uint64_t value = script.number();
    if (script.one_in(3)) {
      const std::size_t all = few_slots * sizeof(RingSlot) / 8;
      std::memcpy(reinterpret_cast<std::byte*>(writers_.slots) + script.word() % all * 8, &value,
                  8);
      return;
    }
    RingSlot& next = writers_.slots[(position_ + script.below(2)) % few_slots];
    next.size.store(static_cast<std::uint32_t>(value));
    next.sequence.store(position_ + 1 + script.below(2));
  }

  void say_what_is_true() {
    if (!dishonest_) return;
    readers_.control->slots_taken.store(position_);
    readers_.control->packets_taken.store(read_);
  }
  void lie(Script& script) {
    dishonest_ = true;
    RingControl& control = *readers_.control;
    const std::uint64_t near = script.number();
    control.slots_taken.store(script.one_in(2) ? near : control.slots_taken.load() + near);
    control.packets_taken.store(script.number());
    control.asleep.store(static_cast<std::uint32_t>(near));
    expect(writer_.reader_sleeps() == (control.asleep.load() != 0), "who says so is woken");
  }

  const bool hostile_writer_;
  const Memory writers_memory_{RingMemory::bytes(few_slots)};
  const Memory readers_memory_{RingMemory::control_bytes};
  const RingMemory writers_ = RingMemory::at(writers_memory_.data(), few_slots);
  const RingMemory readers_ = RingMemory::at(readers_memory_.data(), 0);
  RingWriter writer_{writers_};
  RingReader reader_{*readers_.control, writers_};
  std::deque<Sent> sent_;
  std::uint64_t written_ = 0;
  std::uint64_t read_ = 0;
  std::uint64_t position_ = 0;  // of the reader
  std::size_t used_ = 0;        // slots between the two
  bool dishonest_ = false;      // one of them has scribbled over what is under way, or has lied
};

/// A stream whose writer is hostile: readers only look, so there is no other way.
void try_stream(Script script) {
  const std::size_t largest = script.below(200);
  const std::size_t depth = 1 + script.below(9);
  const auto held = std::make_shared<Memory>(StreamMemory::bytes(largest, depth));
  const StreamMemory memory{held->data(), largest, depth};
  StreamRingWriter writer(memory, held);
  StreamWatches watches;
  auto reader = watches.open(memory, held);
  StreamSample sample;
  std::uint64_t published = 0;
  std::uint64_t past = 0;
  bool scribbled = false;
  for (int step = 0; step < 300 && !script.over(); ++step) {
    switch (script.below(6)) {
      case 0: {
        const std::size_t size = script.below(220);
        const Bytes bytes = content(published + 1, size);
        const bool went = writer.publish(bytes, static_cast<std::int64_t>(published)).has_value();
        expect(went == (size <= largest), "a sample goes that is not too large");
        if (went) ++published;
        break;
      }
      case 1:
      case 2: {
        const bool newest = script.one_in(2);
        const std::uint64_t after = script.one_in(8) ? script.number() : sample.sequence;
        const bool got = newest ? reader->latest(after, sample) : reader->next(after, sample);
        if (got) expect(sample.bytes.size() <= largest, "no sample is larger than the largest");
        if (got) expect(sample.sequence > after, "a stream goes forward");
        if (scribbled) break;
        const std::uint64_t from = after == 0 && !newest ? past : after;
        expect(got == (published > from), "what was published is read");
        if (!got) break;
        const std::uint64_t oldest = published > depth ? published - depth + 1 : 1;
        expect(sample.sequence == (newest ? published : std::max(from + 1, oldest)),
               "the newest, or the oldest that is kept and new");
        expect(sample.bytes == content(sample.sequence, sample.bytes.size()) &&
                   sample.stamp_ns + 1 == static_cast<std::int64_t>(sample.sequence),
               "a sample is whole");
        break;
      }
      case 3:
        watches.anything_new();
        break;
      case 4:
        if (scribbled) break;
        reader = watches.open(memory, held);
        past = published == 0 ? 0 : published - 1;
        break;
      case 5: {
        scribbled = true;
        const std::uint64_t value = script.number();
        if (script.one_in(2)) memory.newest().store(value);
        auto* const slot = memory.slot(script.one_in(2) ? value : script.byte());
        slot[script.below(3)].store(script.one_in(2) ? 2 * value : script.number());
        break;
      }
    }
  }
}

}  // namespace

void try_rings(ByteView input) {
  Script script(input);
  switch (script.below(4)) {
    case 0:
      return Ring(true).run(script);
    case 1:
      return Ring(false).run(script);
    case 2:
      return try_stream(script);
    case 3:
      return try_shm_connection(script);
  }
}

}  // namespace gecos::fuzz
