#include "gecos/media/buffers/ring.hpp"

#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <random>
#include <string>
#include <thread>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/process_barrier.hpp"
#include "gecos/base/suspension.hpp"
#include "gecos/media/buffers/mapping.hpp"
#include "gecos/media/buffers/stream_ring.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t few_slots = 512;

/// Both sides in one mapping, so that a thread sanitizer sees them.
struct TwoSides {
  Mapping a = Mapping::anonymous(RingMemory::bytes(few_slots));
  Mapping b = Mapping::anonymous(RingMemory::bytes(few_slots));
  RingMemory writer_memory = RingMemory::at(a.data(), few_slots);
  RingMemory reader_memory = RingMemory::at(b.data(), few_slots);
  RingWriter writer{writer_memory};
  RingReader reader{*reader_memory.control, writer_memory};
  TwoSides() { writer.set_reader(reader_memory.control); }
};

/// Makes the kernel refuse membarrier(2) to this thread from now on.
bool forbid_membarrier() {
  sock_filter steps[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_membarrier, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter{static_cast<unsigned short>(std::size(steps)), steps};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

Bytes packet(std::size_t size, std::uint64_t seed) {
  Bytes bytes(size);
  std::mt19937_64 random(seed);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

/// The moment on a machine that has been suspended for `suspended` longer than this one.
class AfterSuspension final : public Clock {
 public:
  explicit AfterSuspension(Duration suspended) : suspended_(suspended) {}
  TimePoint now() const override { return SystemClock().now(); }
  TimePoint since_boot() const override { return SystemClock().since_boot() + suspended_; }
  Duration unix_time() const override { return SystemClock().unix_time(); }

 private:
  const Duration suspended_;
};

TEST(Ring, APacketAgesWhileTheMachineIsSuspended) {
  using std::chrono::seconds;
  TwoSides ring;
  ASSERT_TRUE(ring.writer.write(packet(10, 1), {}));
  const auto noted = [](Duration suspended) {
    const Duration before = noted_suspension();
    while (noted_suspension() - before < suspended / 2) {
      note_suspension(AfterSuspension(suspended));  // it may be kept from running, and says nothing
    }
  };
  noted(seconds(5));
  ASSERT_TRUE(ring.reader.read());
  EXPECT_GE(ring.reader.age(), seconds(5) - std::chrono::milliseconds(10));
  note_suspension(SystemClock());
}

TEST(Ring, GivesBackPacketsOfEverySizeInOrder) {
  TwoSides ring;
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, slot_payload - 1, slot_payload, slot_payload + 1,
        2 * slot_payload, std::size_t{5000}, largest_ring_packet}) {
    const Bytes sent = packet(size, size);
    const std::size_t head = size / 3;
    ASSERT_TRUE(ring.writer.write(ByteView(sent).first(head), ByteView(sent).subspan(head)));
    const auto got = ring.reader.read();
    ASSERT_TRUE(got);
    EXPECT_TRUE(std::ranges::equal(*got, sent)) << size;
    EXPECT_FALSE(ring.reader.read());
  }
}

TEST(Ring, WithoutAKnownReaderItCanBeFilledOnce) {
  Mapping memory = Mapping::anonymous(RingMemory::bytes(few_slots));
  RingWriter writer(RingMemory::at(memory.data(), few_slots));
  for (std::size_t i = 0; i < few_slots; ++i) ASSERT_TRUE(writer.write({}, {}));
  EXPECT_EQ(writer.write({}, {}).error(), SendProblem::Full);
  EXPECT_FALSE(writer.reader_sleeps());
  EXPECT_EQ(writer.taken(), 0u);
}

/// Lets each of two threads answer the other's packet and then sleep at once, so that each packet
/// meets a reader that is about to sleep. A lost wake-up leaves both asleep.
class SleepyPair {
 public:
  explicit SleepyPair(bool barriers) {
    for (std::size_t side : {0, 1}) {
      if (barriers) use_barriers(*sides_[side].memory.control);
      sides_[side].writer.set_reader(sides_[1 - side].memory.control);
    }
  }

  /// Returns how many of `rounds` packets the first side has sent and seen answered.
  int exchange(int rounds) {
    std::thread other([&] { run(sides_[1], sides_[0], rounds); });
    sides_[0].writer.write({}, {});
    wake(sides_[0], sides_[1]);
    const int answered = run(sides_[0], sides_[1], rounds);
    other.join();
    return answered;
  }

 private:
  struct Side {
    Mapping mapping = Mapping::anonymous(RingMemory::bytes(few_slots));
    RingMemory memory = RingMemory::at(mapping.data(), few_slots);
    RingWriter writer{memory};
    EventFd event;
  };

  static void wake(Side& from, Side& to) {
    if (from.writer.reader_sleeps()) to.event.notify();
  }
  static int run(Side& own, Side& other, int rounds) {
    RingReader reader(*own.memory.control, other.memory);
    for (int taken = 0; taken < rounds;) {
      if (reader.read()) {
        ++taken;
        own.writer.write({}, {});
        wake(own, other);
        continue;
      }
      const bool announced = announce_sleep(*own.memory.control);
      if (announced && !reader.ready()) {
        pollfd woken{own.event.descriptor(), POLLIN, 0};
        if (::poll(&woken, 1, 10'000) != 1) return taken;
      }
      own.memory.control->asleep.store(0);
      own.event.drain();
    }
    return rounds;
  }

  std::array<Side, 2> sides_;
};

TEST(Ring, NoWakeUpIsLostWhileAReaderFallsAsleep) {
  EXPECT_EQ(SleepyPair(false).exchange(10'000), 10'000);
  if (!join_barriers()) GTEST_SKIP() << "this kernel, or a seccomp filter, forbids membarrier(2)";
  EXPECT_EQ(SleepyPair(true).exchange(60'000), 60'000);
}

TEST(Ring, AReaderWhoseBarrierIsRefusedDoesNotSleepAndUsesNoneLater) {
  constexpr int no_filter = 77;
  const pid_t child = ::fork();
  if (child == 0) {
    if (!forbid_membarrier()) ::_exit(no_filter);
    RingControl own;
    own.barriers.store(1);
    const bool slept = announce_sleep(own);
    ::_exit(!slept && own.barriers.load() == 0 && announce_sleep(own) ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == no_filter) GTEST_SKIP() << "this kernel has no seccomp filters";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(Ring, AReaderThatLiesAboutItsProgressOnlyKeepsTheRingFull) {
  TwoSides ring;
  for (std::size_t i = 0; i < few_slots; ++i) ASSERT_TRUE(ring.writer.write({}, {}));
  for (const std::uint64_t lie : {~std::uint64_t{0}, std::uint64_t{few_slots + 1}}) {
    ring.reader_memory.control->slots_taken.store(lie);
    ring.reader_memory.control->packets_taken.store(lie);
    EXPECT_EQ(ring.writer.write({}, {}).error(), SendProblem::Full);
    EXPECT_LE(ring.writer.taken(), few_slots);
  }
}

TEST(Ring, AWriterThatLiesAboutASizeBreaksTheRing) {
  TwoSides ring;
  RingSlot& slot = ring.writer_memory.slots[0];
  slot.size.store(largest_ring_packet + 1);
  slot.sequence.store(1);
  EXPECT_FALSE(ring.reader.read());
  EXPECT_TRUE(ring.reader.broken());
  slot.size.store(1);
  EXPECT_FALSE(ring.reader.read()) << "a broken ring stays broken";
}

TEST(Ring, AScribblingWriterNeverLeadsTheReaderAstray) {
  std::mt19937_64 random(7);
  for (int round = 0; round < 2000; ++round) {
    TwoSides ring;
    for (int i = 0; i < 20; ++i) {
      const std::size_t at = random() % 4;
      RingSlot& slot = ring.writer_memory.slots[at];
      slot.sequence.store(at + 1);
      slot.size.store(static_cast<std::uint32_t>(random() >> (32 + random() % 32)));
      if (const auto got = ring.reader.read()) {
        EXPECT_LE(got->size(), largest_ring_packet);
      }
    }
  }
}

TEST(Ring, NothingIsLostBetweenTwoThreads) {
  TwoSides ring;
  constexpr std::uint64_t count = 20'000;
  std::thread writing([&] {
    std::mt19937_64 random(1);
    for (std::uint64_t i = 0; i < count; ++i) {
      const Bytes body(random() % 600, static_cast<std::byte>(i));
      while (!ring.writer.write(std::as_bytes(std::span(&i, 1)), body)) std::this_thread::yield();
    }
  });
  std::mt19937_64 random(1);
  for (std::uint64_t i = 0; i < count;) {
    const auto got = ring.reader.read();
    if (!got) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(got->size(), sizeof i + random() % 600);
    ASSERT_EQ(std::memcmp(got->data(), &i, sizeof i), 0);
    for (const std::byte byte : got->subspan(sizeof i)) ASSERT_EQ(byte, static_cast<std::byte>(i));
    ++i;
  }
  writing.join();
  EXPECT_EQ(ring.writer.taken(), count);
}

struct OneStream {
  OneStream(std::size_t largest, std::size_t depth)
      : mapping(std::make_shared<Mapping>(Mapping::anonymous(StreamMemory::bytes(largest, depth)))),
        memory{mapping->data(), largest, depth},
        writer(memory, mapping) {}
  std::shared_ptr<Mapping> mapping;
  StreamMemory memory;
  StreamRingWriter writer;
  StreamWatches watches;
};

TEST(StreamRing, NoReaderSeesATornSample) {
  OneStream stream(512, 2);
  std::atomic<bool> done{false};
  std::thread writing([&] {
    for (std::uint64_t i = 1; i <= 30'000; ++i) {
      const Bytes sample(8 + i % 500, static_cast<std::byte>(i));
      ASSERT_TRUE(stream.writer.publish(sample, static_cast<std::int64_t>(i)));
    }
    done.store(true);
  });
  const auto reader = stream.watches.open(stream.memory, stream.mapping);
  const auto whole = [](const StreamSample& sample) {
    return sample.stamp_ns == static_cast<std::int64_t>(sample.sequence) &&
           sample.bytes ==
               Bytes(8 + sample.sequence % 500, static_cast<std::byte>(sample.sequence));
  };
  StreamSample sample;
  std::uint64_t read = 0;
  for (bool last = false; !last;) {
    last = done.load();
    while (read % 2 == 0 ? reader->next(sample.sequence, sample)
                         : reader->latest(sample.sequence, sample)) {
      ++read;
      ASSERT_TRUE(whole(sample)) << sample.sequence;
      const auto stored = reader->stored();
      ASSERT_LE(stored.size(), 2u);
      ASSERT_TRUE(std::ranges::all_of(stored, whole));
    }
  }
  writing.join();
  EXPECT_EQ(sample.sequence, 30'000u);
  EXPECT_GT(read, 0u);
}

TEST(StreamRing, ALateReaderBeginsWithTheNewestSample) {
  OneStream stream(64, 4);
  for (int i = 1; i <= 3; ++i) ASSERT_TRUE(stream.writer.publish(packet(8, i), i));
  const auto reader = stream.watches.open(stream.memory, stream.mapping);
  StreamSample sample;
  ASSERT_TRUE(reader->next(0, sample));
  EXPECT_EQ(sample.sequence, 3u);
  EXPECT_FALSE(reader->next(sample.sequence, sample));
  ASSERT_TRUE(stream.writer.publish(packet(8, 4), 4));
  ASSERT_TRUE(stream.writer.publish(packet(8, 5), 5));
  ASSERT_TRUE(reader->next(sample.sequence, sample));
  EXPECT_EQ(sample.sequence, 4u);
}

TEST(StreamRing, AWriterThatDiedInTheMiddleHoldsNobody) {
  OneStream stream(64, 2);
  ASSERT_TRUE(stream.writer.publish(packet(8, 1), 1));
  const auto reader = stream.watches.open(stream.memory, stream.mapping);
  stream.memory.slot(1)[0].store(7);  // odd: somebody is writing, for ever
  StreamSample sample;
  EXPECT_FALSE(reader->latest(0, sample));
  EXPECT_FALSE(reader->next(0, sample));
}

TEST(StreamRing, AWriterThatLiesNeverLeadsTheReaderAstray) {
  OneStream stream(64, 4);
  const auto reader = stream.watches.open(stream.memory, stream.mapping);
  std::mt19937_64 random(3);
  StreamSample sample;
  for (int round = 0; round < 20'000; ++round) {
    const std::uint64_t newest = random() >> (random() % 64);
    stream.memory.newest().store(newest);
    stream.memory.slot(newest)[0].store(2 * newest);
    stream.memory.slot(newest)[2].store(random() >> (random() % 64));
    if (reader->latest(0, sample)) {
      EXPECT_LE(sample.bytes.size(), 64u);
    }
    if (reader->next(0, sample)) {
      EXPECT_LE(sample.bytes.size(), 64u);
    }
    const auto stored = reader->stored();
    EXPECT_LE(stored.size(), 4u);
    for (const StreamSample& kept : stored) EXPECT_LE(kept.bytes.size(), 64u);
  }
}

}  // namespace
}  // namespace gecos::media
