// A peer that breaks every rule of shm: it is cut off, and nobody crashes, hangs or leaks.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <thread>
#include <utility>

#include "gecos/base/event_fd.hpp"
#include "gecos/media/buffers/bulk.hpp"
#include "gecos/media/buffers/ring.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/media/shm/control.hpp"
#include "gecos/media/shm/memory.hpp"
#include "gecos/media/shm/shm.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

using shm::ControlMessage;
using shm::ControlType;

constexpr std::size_t ring_bytes = RingMemory::bytes(usual_slot_count);

Descriptor connect_raw(const std::string& address) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  const std::string path = address.substr(4);
  std::copy(path.begin(), path.end(), to.sun_path);
  Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  EXPECT_EQ(::connect(socket.get(), reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  return socket;
}

Descriptor memfd_of(std::size_t size, int seals) {
  Descriptor made(::memfd_create("hostile", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  EXPECT_EQ(::ftruncate(made.get(), static_cast<off_t>(size)), 0);
  if (seals != 0) {
    EXPECT_EQ(::fcntl(made.get(), F_ADD_SEALS, seals), 0);
  }
  return made;
}

class ShmHostile : public testing::Test {
 protected:
  void SetUp() override { before_ = open_descriptors(); }

  /// Whoever it was, it made no connection, it holds no descriptor of ours, and others are served.
  void expect_refused() {
    EXPECT_EQ(acceptor_->accept(), nullptr);
    EXPECT_EQ(acceptor_->accept(), nullptr);
    expect_served();
  }
  void expect_served() {
    End client(std::move(*medium_->connect(acceptor_->address())));
    End server(wait_for_client(*acceptor_));
    ASSERT_NE(server.connection, nullptr);
    ASSERT_TRUE(client.send("an honest call"));
    EXPECT_EQ(server.receive(), "an honest call");
  }
  void expect_hello_refused(int memfd, int event) {
    const Descriptor socket = connect_raw(acceptor_->address());
    const std::array given{memfd, event};
    ASSERT_TRUE(shm::send_control(socket.get(), {.type = ControlType::Hello}, given));
    expect_refused();
  }
  void TearDown() override {
    while (acceptor_->accept() != nullptr) {
    }
    EXPECT_EQ(open_descriptors(), before_) << "descriptors leaked";
  }

  const ScratchDirectory directory_;
  const std::unique_ptr<Medium> medium_ = make_shm({.directory = directory_.path()});
  const std::unique_ptr<Acceptor> acceptor_ = medium_->listen("RX90", false).value();
  std::size_t before_ = 0;
};

/// A client with honest memory that writes what it likes.
struct Scribbler {
  explicit Scribbler(const std::string& address) : socket(connect_raw(address)) {
    memory = shm::make_sealed("scribbler", ring_bytes).value();
    ring = RingMemory::at(memory.mapping.data(), usual_slot_count);
    const std::array given{memory.memfd.get(), event.descriptor()};
    EXPECT_TRUE(shm::send_control(socket.get(), {.type = ControlType::Hello}, given));
  }
  Descriptor socket;
  shm::SealedMemory memory;
  RingMemory ring;
  EventFd event;
};

TEST_F(ShmHostile, GarbageOnTheSocketIsNoHello) {
  std::mt19937_64 random(1);
  for (const std::size_t size : {1u, 10u, 160u, 161u, 5000u}) {
    const Descriptor socket = connect_raw(acceptor_->address());
    std::string garbage(size, ' ');
    for (char& c : garbage) c = static_cast<char>(random());
    ASSERT_EQ(::send(socket.get(), garbage.data(), size, 0), static_cast<ssize_t>(size));
    expect_refused();
  }
}

TEST_F(ShmHostile, AHelloWithoutMemoryIsRefused) {
  const Descriptor socket = connect_raw(acceptor_->address());
  ASSERT_TRUE(shm::send_control(socket.get(), {.type = ControlType::Hello}));
  expect_refused();
}

TEST_F(ShmHostile, UnsealedMemoryIsRefused) {
  const EventFd event;
  expect_hello_refused(memfd_of(ring_bytes, 0).get(), event.descriptor());
  expect_hello_refused(memfd_of(ring_bytes, F_SEAL_GROW | F_SEAL_FUTURE_WRITE).get(),
                       event.descriptor());
}

TEST_F(ShmHostile, MemoryOfAnotherSizeIsRefused) {
  const EventFd event;
  constexpr int all = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
  expect_hello_refused(memfd_of(std::size_t{1} << 40, all).get(), event.descriptor());
  expect_hello_refused(memfd_of(ring_bytes - 1, all).get(), event.descriptor());
  expect_hello_refused(memfd_of(0, all).get(), event.descriptor());
}

TEST_F(ShmHostile, AFileIsNoMemory) {
  const EventFd event;
  const Descriptor file(::open("/dev/zero", O_RDWR | O_CLOEXEC));
  expect_hello_refused(file.get(), event.descriptor());
  const Descriptor event_twice(::dup(event.descriptor()));
  expect_hello_refused(event_twice.get(), event.descriptor());
}

TEST_F(ShmHostile, AnEventFdThatIsNoneIsNeverNotified) {
  // A full pipe would block who writes to it: the socket is used instead.
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  const Descriptor reading(ends[0]);
  const Descriptor writing(ends[1]);
  ASSERT_EQ(::fcntl(writing.get(), F_SETFL, O_NONBLOCK), 0);
  const std::string much(65536, 'x');
  while (::write(writing.get(), much.data(), much.size()) > 0) {
  }
  ASSERT_EQ(::fcntl(writing.get(), F_SETFL, 0), 0);

  const Descriptor socket = connect_raw(acceptor_->address());
  auto memory = shm::make_sealed("hostile", ring_bytes).value();
  RingMemory::at(memory.mapping.data(), usual_slot_count).control->asleep.store(1);
  const std::array given{memory.memfd.get(), writing.get()};
  ASSERT_TRUE(shm::send_control(socket.get(), {.type = ControlType::Hello}, given));
  const auto connection = wait_for_client(*acceptor_);
  ASSERT_NE(connection, nullptr);
  ASSERT_TRUE(connection->send(bytes_of("wake up"), {}));
  shm::ReceivedControl got;
  ASSERT_EQ(shm::receive_control(socket.get(), got), shm::ControlRead::Message);
  EXPECT_EQ(got.message.type, ControlType::Welcome);
  ASSERT_EQ(shm::receive_control(socket.get(), got), shm::ControlRead::Message);
  EXPECT_EQ(got.message.type, ControlType::Notify);
}

TEST_F(ShmHostile, AFloodOfDescriptorsIsClosed) {
  const Descriptor socket = connect_raw(acceptor_->address());
  std::array<int, 100> many;
  many.fill(socket.get());
  ControlMessage hello{.type = ControlType::Hello};
  iovec piece{&hello, sizeof hello};
  std::array<char, CMSG_SPACE(sizeof many)> space{};
  msghdr header{};
  header.msg_iov = &piece;
  header.msg_iovlen = 1;
  header.msg_control = space.data();
  header.msg_controllen = space.size();
  cmsghdr* const first = CMSG_FIRSTHDR(&header);
  first->cmsg_level = SOL_SOCKET;
  first->cmsg_type = SCM_RIGHTS;
  first->cmsg_len = CMSG_LEN(sizeof many);
  std::memcpy(CMSG_DATA(first), many.data(), sizeof many);
  ASSERT_GT(::sendmsg(socket.get(), &header, 0), 0);
  expect_refused();
}

TEST_F(ShmHostile, SilentPeersDoNotKeepHonestOnesOut) {
  std::vector<Descriptor> silent;
  for (int i = 0; i < 200; ++i) {
    silent.push_back(connect_raw(acceptor_->address()));
    if (i % 20 == 0) {
      EXPECT_EQ(acceptor_->accept(), nullptr);
    }
  }
  expect_served();
}

TEST_F(ShmHostile, OfMoreThanSixtyFourPeersWithoutAHelloTheOldestIsDropped) {
  std::vector<Descriptor> silent;
  const auto dropped = [&] {
    std::array<char, 512> message;
    const auto got = ::recv(silent.front().get(), message.data(), message.size(), MSG_DONTWAIT);
    return got >= 0 || errno != EAGAIN;  // a goodbye, or the end of the connection
  };
  for (int i = 0; i < 64; ++i) silent.push_back(connect_raw(acceptor_->address()));
  EXPECT_EQ(acceptor_->accept(), nullptr);
  EXPECT_FALSE(dropped());
  silent.push_back(connect_raw(acceptor_->address()));
  EXPECT_EQ(acceptor_->accept(), nullptr);
  EXPECT_TRUE(dropped());
}

TEST_F(ShmHostile, AConnectionThatSendsGarbageLaterIsBroken) {
  for (const ControlType type : {ControlType::Hello, ControlType::Welcome, ControlType::Share,
                                 ControlType::Area, static_cast<ControlType>(99)}) {
    const Scribbler scribbler(acceptor_->address());
    const auto connection = wait_for_client(*acceptor_);
    ASSERT_NE(connection, nullptr);
    ASSERT_EQ(connection->loss(), Loss::None);
    ASSERT_TRUE(shm::send_control(scribbler.socket.get(), {.type = type}));
    EXPECT_EQ(connection->loss(), Loss::Broken);
    EXPECT_FALSE(connection->loss_text().empty());
    EXPECT_FALSE(connection->prepare_to_sleep());
  }
}

TEST_F(ShmHostile, AFloodOfNotificationsDelaysButNeverHolds) {
  const Scribbler scribbler(acceptor_->address());
  const auto connection = wait_for_client(*acceptor_);
  ASSERT_NE(connection, nullptr);
  for (int round = 0; round < 100; ++round) {
    while (shm::send_control(scribbler.socket.get(), {.type = ControlType::Notify})) {
    }
    connection->prepare_to_sleep();
    connection->woke();
    ASSERT_EQ(connection->loss(), Loss::None);
  }
}

TEST_F(ShmHostile, AScribbledRingGivesPacketsOrBreaksButHurtsNobody) {
  std::mt19937_64 random(11);
  for (int round = 0; round < 50; ++round) {
    const Scribbler scribbler(acceptor_->address());
    const auto connection = wait_for_client(*acceptor_);
    ASSERT_NE(connection, nullptr);
    for (int i = 0; i < 2000 && connection->loss() == Loss::None; ++i) {
      auto* const words = reinterpret_cast<std::uint64_t*>(scribbler.memory.mapping.data());
      const std::uint64_t value = random() >> (random() % 64);
      // Anything anywhere, and now and then just what the reader looks at next.
      words[random() % (ring_bytes / sizeof *words)] = value;
      RingSlot& slot = scribbler.ring.slots[static_cast<std::size_t>(i) % 8];
      slot.size.store(static_cast<std::uint32_t>(value));
      slot.sequence.store(static_cast<std::uint64_t>(i) % 8 + 1);
      if (const auto packet = connection->receive()) {
        ASSERT_LE(packet->size(), largest_ring_packet);
      }
      [[maybe_unused]] const auto sent = connection->send(bytes_of("x"), {});
      ASSERT_LE(connection->taken_by_peer(), 2000u);
      connection->beats_seen();
      if (connection->prepare_to_sleep()) connection->woke();
    }
  }
  expect_served();
}

TEST_F(ShmHostile, ASizeThatChangesWhileItIsReadHurtsNobody) {
  const Scribbler scribbler(acceptor_->address());
  const auto connection = wait_for_client(*acceptor_);
  ASSERT_NE(connection, nullptr);
  std::atomic<bool> done{false};
  std::thread scribbling([&] {
    for (std::uint32_t i = 0; !done.load(); ++i) {
      for (std::size_t slot = 0; slot < 16; ++slot) {
        scribbler.ring.slots[slot].size.store(i % 2 == 0 ? 1 : 0xffffffff);
      }
    }
  });
  for (std::size_t slot = 0; slot < 16; ++slot) scribbler.ring.slots[slot].sequence.store(slot + 1);
  for (int i = 0; i < 16; ++i) {
    if (const auto packet = connection->receive()) {
      EXPECT_LE(packet->size(), largest_ring_packet);
    }
  }
  done.store(true);
  scribbling.join();
}

/// What a scribbler says of its areas, and of the packets in them.
struct BulkScribbler : Scribbler {
  using Scribbler::Scribbler;
  bool show(int memfd, std::uint64_t number = 1) {
    const std::array given{memfd};
    return shm::send_control(socket.get(), {.type = ControlType::Area, .largest = number}, given);
  }
  bool end(std::uint64_t number) {
    return shm::send_control(socket.get(), {.type = ControlType::AreaEnd, .largest = number});
  }
  RingWriter writer{ring};
};

TEST_F(ShmHostile, AnAreaThatCouldHurtLaterBreaksTheConnection) {
  constexpr int all = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
  struct Case {
    std::size_t size;
    int seals;
  };
  for (const auto& [size, seals] :
       {Case{area_bytes, 0}, Case{area_bytes, F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL},
        Case{area_bytes, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL}, Case{area_bytes - 1, all},
        Case{0, all}, Case{std::size_t{1} << 40, all}}) {
    BulkScribbler scribbler(acceptor_->address());
    const auto connection = wait_for_client(*acceptor_);
    ASSERT_NE(connection, nullptr);
    const Descriptor memfd = memfd_of(size, seals);
    ASSERT_TRUE(scribbler.show(memfd.get()));
    scribbler.writer.announce({1, 0, 100});
    EXPECT_FALSE(connection->receive());
    EXPECT_EQ(connection->loss(), Loss::Broken) << size << " " << seals;
    EXPECT_FALSE(connection->prepare_to_sleep());
  }
}

TEST_F(ShmHostile, AnAreaThatWasAnnouncedButNeverShownBreaksTheConnection) {
  BulkScribbler scribbler(acceptor_->address());
  const auto connection = wait_for_client(*acceptor_);
  ASSERT_NE(connection, nullptr);
  scribbler.writer.announce({1, 0, 100});
  EXPECT_FALSE(connection->receive());
  EXPECT_EQ(connection->loss(), Loss::Broken);
}

TEST_F(ShmHostile, AnAreaBehindAFullSocketIsFound) {
  BulkScribbler scribbler(acceptor_->address());
  const auto connection = wait_for_client(*acceptor_);
  ASSERT_NE(connection, nullptr);
  int sent = 0;
  while (shm::send_control(scribbler.socket.get(), {.type = ControlType::Notify})) ++sent;
  ASSERT_GT(sent, 64);
  ASSERT_EQ(connection->loss(), Loss::None);  // reads some of them, which makes room
  const auto area = shm::make_sealed("hostile", area_bytes).value();
  ASSERT_TRUE(scribbler.show(area.memfd.get()));
  scribbler.writer.announce({1, 0, 100'000});
  const auto packet = connection->receive();
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->size(), 100'000u);
}

TEST_F(ShmHostile, PagesThatWereNeverWrittenAreReadAsZeros) {
  BulkScribbler scribbler(acceptor_->address());
  const auto connection = wait_for_client(*acceptor_);
  ASSERT_NE(connection, nullptr);
  const auto area = shm::make_sealed("hostile", area_bytes).value();
  ASSERT_TRUE(scribbler.show(area.memfd.get()));
  scribbler.writer.announce({1, 0, largest_bulk_packet});
  const auto packet = connection->receive();
  ASSERT_TRUE(packet);
  EXPECT_TRUE(std::ranges::all_of(*packet, [](std::byte b) { return b == std::byte{0}; }));
}

TEST_F(ShmHostile, AreasThatComeAndEndWhileTheyAreReadHurtNobody) {
  BulkScribbler scribbler(acceptor_->address());
  const auto connection = wait_for_client(*acceptor_);
  ASSERT_NE(connection, nullptr);
  const auto area = shm::make_sealed("hostile", area_bytes).value();
  std::atomic<bool> done{false};
  // Maintenance reads the socket in another thread than the one that copies.
  std::thread maintenance([&] {
    while (!done.load()) {
      connection->loss();
      connection->beat();
    }
  });
  for (std::uint64_t number = 1; number <= 300 && connection->loss() == Loss::None; ++number) {
    if (!scribbler.show(area.memfd.get(), number)) continue;
    scribbler.writer.announce({number, 0, 3'000'000});
    scribbler.end(number);  // before it was read
    if (const auto packet = connection->receive()) {
      EXPECT_EQ(packet->size(), 3'000'000u);
    }
  }
  done.store(true);
  maintenance.join();
}

TEST_F(ShmHostile, ScribbledPlacesGivePacketsOrBreakButHurtNobody) {
  std::mt19937_64 random(17);
  const auto area = shm::make_sealed("hostile", area_bytes).value();
  for (int round = 0; round < 100; ++round) {
    BulkScribbler scribbler(acceptor_->address());
    const auto connection = wait_for_client(*acceptor_);
    ASSERT_NE(connection, nullptr);
    ASSERT_TRUE(scribbler.show(area.memfd.get(), 1));
    for (int i = 0; i < 100 && connection->loss() == Loss::None; ++i) {
      const auto any = [&] {
        return i % 4 == 0 ? random() >> (random() % 64) : random() % 200'000;
      };
      scribbler.writer.announce({any() % 20 == 0 ? any() : 1, any(), any()});
      if (const auto packet = connection->receive()) {
        ASSERT_LE(packet->size(), largest_bulk_packet);
      }
    }
  }
}

TEST_F(ShmHostile, WhoNeverTakesLargePacketsFillsOnlyItsOwnArea) {
  BulkScribbler scribbler(acceptor_->address());
  const auto connection = wait_for_client(*acceptor_);
  ASSERT_NE(connection, nullptr);
  const Bytes image(2'000'000);
  const std::size_t before = open_descriptors();
  std::uint64_t sent = 0;
  while (connection->send(image, {})) ++sent;
  EXPECT_EQ(connection->send(image, {}).error(), SendProblem::Full);
  EXPECT_LE(sent * image.size(), area_bytes);
  for (unsigned i = 0; i < 2 * area_kept; ++i) connection->beat();
  EXPECT_EQ(connection->send(image, {}).error(), SendProblem::Full)
      << "what is not taken is not given back";
  EXPECT_EQ(connection->taken_by_peer(), 0u);
  EXPECT_EQ(open_descriptors(), before) << "an area is held by its mapping alone";
  expect_served();
}

TEST_F(ShmHostile, AReaderCannotWriteTheMemoryOfAStream) {
  const Scribbler reader(acceptor_->address());
  const auto connection = wait_for_client(*acceptor_);
  ASSERT_NE(connection, nullptr);
  const auto writer = acceptor_->make_stream(64, 4);
  ASSERT_TRUE(connection->share(1, *writer));
  shm::ReceivedControl got;
  while (got.message.type != ControlType::Share) {
    ASSERT_EQ(shm::receive_control(reader.socket.get(), got), shm::ControlRead::Message);
  }
  const int memfd = got.descriptors[0].get();
  const std::size_t size = StreamMemory::bytes(got.message.largest, got.message.depth);
  const auto map = [&](int descriptor, int rights) {
    return ::mmap(nullptr, size, rights, MAP_SHARED, descriptor, 0);
  };
  void* const read = map(memfd, PROT_READ);
  ASSERT_NE(read, MAP_FAILED);
  EXPECT_NE(::mprotect(read, size, PROT_READ | PROT_WRITE), 0);
  EXPECT_EQ(::munmap(read, size), 0);
  EXPECT_EQ(map(memfd, PROT_READ | PROT_WRITE), MAP_FAILED);
  EXPECT_EQ(errno, EPERM);
  EXPECT_EQ(::pwrite(memfd, "x", 1, 0), -1);
  const std::string path = "/proc/self/fd/" + std::to_string(memfd);
  const Descriptor opened_again(::open(path.c_str(), O_RDWR | O_CLOEXEC));
  ASSERT_TRUE(opened_again);
  EXPECT_EQ(map(opened_again.get(), PROT_READ | PROT_WRITE), MAP_FAILED);
}

/// A server that answers a client's Hello and then does what it likes.
class HostileServer {
 public:
  explicit HostileServer(const std::string& directory) : path_(directory + "/EVIL.sock") {
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    std::copy(path_.begin(), path_.end(), at.sun_path);
    EXPECT_EQ(::bind(listener_.get(), reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
    EXPECT_EQ(::listen(listener_.get(), 8), 0);
  }
  std::string address() const { return "shm:" + path_; }
  Descriptor accept() const {
    Descriptor socket(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
    shm::ReceivedControl hello;
    EXPECT_EQ(shm::receive_control(socket.get(), hello), shm::ControlRead::Message);
    return socket;
  }

 private:
  const std::string path_;
  const Descriptor listener_{::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)};
};

TEST_F(ShmHostile, AClientRefusesAServersUnsealedMemory) {
  const HostileServer server(directory_.path());
  End client(std::move(*medium_->connect(server.address())));
  const Descriptor socket = server.accept();
  const EventFd event;
  const Descriptor memfd = memfd_of(ring_bytes, 0);
  const std::array given{memfd.get(), event.descriptor()};
  ASSERT_TRUE(shm::send_control(socket.get(), {.type = ControlType::Welcome}, given));
  EXPECT_EQ(client.wait_for_loss(), Loss::Broken);
  EXPECT_EQ(client.connection->loss_text(), "the peer sent memory that is not sealed");
}

TEST_F(ShmHostile, AClientRefusesStreamsOfImpossibleSizes) {
  struct Case {
    std::uint64_t largest;
    std::uint64_t depth;
  };
  constexpr std::uint64_t all_ones = ~std::uint64_t{0};
  const HostileServer server(directory_.path());
  for (const auto& [largest, depth] :
       {Case{all_ones, all_ones}, Case{64, 0}, Case{64, all_ones}, Case{all_ones - 8, 4},
        Case{std::size_t{1} << 31, 1}, Case{64, 4}}) {
    End client(std::move(*medium_->connect(server.address())));
    const Descriptor socket = server.accept();
    const auto memory = shm::make_sealed("hostile", StreamMemory::bytes(64, 5)).value();
    ControlMessage share{.type = ControlType::Share, .id = 1};
    share.largest = largest;
    share.depth = depth;
    const std::array given{memory.memfd.get()};
    ASSERT_TRUE(shm::send_control(socket.get(), share, given));
    EXPECT_EQ(client.connection->open_stream(1), nullptr);
    EXPECT_EQ(client.connection->loss(), Loss::Broken);
  }
}

/// Shares a stream of this size, with memory for it, under the number 1.
void share_stream(int socket, std::size_t largest, std::size_t depth) {
  const auto memory = shm::make_sealed("hostile", StreamMemory::bytes(largest, depth)).value();
  ControlMessage share{.type = ControlType::Share, .id = 1};
  share.largest = largest;
  share.depth = depth;
  const std::array given{memory.memfd.get()};
  ASSERT_TRUE(shm::send_control(socket, share, given));
}

TEST_F(ShmHostile, AStreamWithLargerSamplesThanItsReaderAcceptsIsNotOpened) {
  const HostileServer server(directory_.path());
  End client(std::move(*medium_->connect(server.address())));
  const Descriptor socket = server.accept();
  share_stream(socket.get(), 4096, 4);
  EXPECT_EQ(client.connection->open_stream(1, {.largest = 4095}), nullptr);
  EXPECT_EQ(client.connection->why_no_stream(1),
            "its samples may have 4096 bytes, and the reader accepts at most 4095");
  EXPECT_NE(client.connection->open_stream(1, {.largest = 4096}), nullptr);
}

TEST_F(ShmHostile, AStreamThatIsReadKeepsItsSize) {
  const HostileServer server(directory_.path());
  for (const auto& [largest, depth] : {std::pair(8192, 4), std::pair(4096, 5)}) {
    End client(std::move(*medium_->connect(server.address())));
    const Descriptor socket = server.accept();
    share_stream(socket.get(), 4096, 4);
    const auto reader = client.connection->open_stream(1, {.largest = 4096});
    ASSERT_NE(reader, nullptr);
    share_stream(socket.get(), 4096, 4);  // the stream moves to other memory
    EXPECT_NE(client.connection->open_stream(1), nullptr);
    share_stream(socket.get(), static_cast<std::size_t>(largest), static_cast<std::size_t>(depth));
    EXPECT_EQ(client.wait_for_loss(), Loss::Broken);
    EXPECT_EQ(client.connection->loss_text(),
              "the peer changed the size of a stream that is being read");
  }
}

}  // namespace
}  // namespace gecos::media
