#include "gecos/media/inproc/inproc.hpp"

#include <unistd.h>

#include <array>
#include <atomic>
#include <deque>
#include <map>
#include <new>
#include <utility>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/fork_watch.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/per_process.hpp"
#include "gecos/media/buffers/bulk.hpp"
#include "gecos/media/buffers/mapping.hpp"
#include "gecos/media/buffers/ring.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/media/quiet.hpp"
#include "gecos/media/registration.hpp"

namespace gecos::media {
namespace {

/// One side of a connection. It owns the memory that this side writes and the other side reads.
struct Side {
  Mapping mapping = Mapping::anonymous(RingMemory::bytes(usual_slot_count));
  RingMemory ring = RingMemory::at(mapping.data(), usual_slot_count);
  EventFd event;                    // this side sleeps on the eventfd; the other side notifies it
  BulkReader bulk{[] {}};           // reads large packets; areas need no announcement
  std::atomic<bool> closed{false};  // read by the other side; earlier packets stay readable

  void wake_if_asleep() {
    if (ring.control->asleep.load(std::memory_order_seq_cst) != 0) event.notify();
  }
  void close() { closed.store(true, std::memory_order_release); }
};

struct SharedStream {
  StreamMemory memory;
  std::shared_ptr<void> owner;
};

/// Both sides of a connection. The connection end that is destroyed last also destroys this pair.
struct SidePair {
  std::array<Side, 2> sides;
  Mutex mutex;
  /// The streams that each side shares with the other side.
  std::array<std::map<std::uint32_t, SharedStream>, 2> streams GECOS_GUARDED_BY(mutex);
  std::atomic<bool> inherited{false};  // true in a forked child; read by both ends
  ForkWatch watch{this, [](void* owner) noexcept {
                    auto& self = *static_cast<SidePair*>(owner);
                    self.inherited.store(true);
                    for (Side& side : self.sides) side.event.close();
                  }};
};

/// Makes the memory areas for the large packets that one side sends.
class InprocAreas final : public AreaMaker {
 public:
  explicit InprocAreas(BulkReader& reader) : reader_(reader) {}
  std::shared_ptr<Mapping> make_area(std::uint64_t number) override {
    try {
      auto area = std::make_shared<Mapping>(Mapping::anonymous(area_bytes));
      reader_.know(number, area);
      return area;
    } catch (const std::bad_alloc&) {
      return nullptr;
    }
  }
  bool release(std::uint64_t number) override {
    reader_.end(number);
    return true;
  }

 private:
  BulkReader& reader_;
};

std::unique_ptr<StreamWriter> make_ring(std::size_t largest, std::size_t depth) {
  auto mapping = std::make_shared<Mapping>(Mapping::anonymous(StreamMemory::bytes(largest, depth)));
  const StreamMemory memory{mapping->data(), largest, depth};
  return std::make_unique<StreamRingWriter>(memory, std::move(mapping));
}

class SideSleeper final : public Sleeper {
 public:
  SideSleeper(std::shared_ptr<SidePair> pair, std::size_t side)
      : pair_(std::move(pair)), side_(side) {}
  void wake_if_asleep() override { pair_->sides[side_].wake_if_asleep(); }

 private:
  const std::shared_ptr<SidePair> pair_;
  const std::size_t side_;
};

class InprocConnection final : public Connection, public QuietSender {
 public:
  InprocConnection(std::shared_ptr<SidePair> pair, std::size_t side)
      : pair_(std::move(pair)),
        side_(side),
        own_(pair_->sides[side]),
        other_(pair_->sides[1 - side]),
        writer_(own_.ring),
        areas_(other_.bulk),
        bulk_(writer_, areas_),
        reader_(*own_.ring.control, other_.ring, &own_.bulk),
        sleeper_(std::make_shared<SideSleeper>(pair_, 1 - side)),
        descriptors_{own_.event.descriptor()},
        peer_{::geteuid(), ::getpid(), "this process"} {
    use_barriers(*own_.ring.control);
    writer_.set_reader(other_.ring.control);
  }
  ~InprocConnection() override {
    for (const auto& [id, sleepers] : shared_) {
      if (const auto list = sleepers.lock()) list->remove(sleeper_.get());
    }
    own_.close();
    other_.event.notify();
  }

  const Capabilities& capabilities() const override { return inproc_capabilities; }
  const Peer& peer() const override { return peer_; }

  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override {
    if (loss() != Loss::None) return tl::unexpected(SendProblem::Lost);
    const bool large = head.size() + body.size() > largest_ring_packet;
    auto number = large ? bulk_.write(head, body) : writer_.write(head, body);
    if (number) wake_reader();
    return number;
  }
  tl::expected<std::uint64_t, SendProblem> send_quietly(ByteView head, ByteView body) override {
    if (head.size() + body.size() > largest_ring_packet) return send(head, body);
    if (loss() != Loss::None) return tl::unexpected(SendProblem::Lost);
    auto number = writer_.write(head, body);
    if (number && writer_.half_full()) wake_reader();
    return number;
  }
  std::optional<ByteView> receive() override {
    note_core(*own_.ring.control);
    return reader_.read();
  }
  Duration age() override { return reader_.age(); }
  std::optional<std::uint64_t> taken_by_peer() override { return writer_.taken(); }

  bool prepare_to_sleep() override {
    own_.bulk.rest();
    const bool announced = announce_sleep(*own_.ring.control);
    if (announced && !reader_.ready() && !watches_.anything_new() && loss() == Loss::None)
      return true;
    own_.ring.control->asleep.store(0, std::memory_order_relaxed);
    return false;
  }
  void woke() override {
    own_.ring.control->asleep.store(0, std::memory_order_relaxed);
    own_.event.drain();
  }
  std::span<const int> descriptors() const override { return descriptors_; }

  void write_word(std::size_t index, std::uint64_t value) override {
    own_.ring.control->words.at(index).store(value, std::memory_order_seq_cst);
  }
  std::uint64_t peer_word(std::size_t index) override {
    return other_.ring.control->words.at(index).load(std::memory_order_seq_cst);
  }

  Whereabouts peer_whereabouts() override { return whereabouts(*other_.ring.control); }
  void beat() override {
    own_.ring.control->beats.fetch_add(1, std::memory_order_relaxed);
    if (loss() == Loss::None) bulk_.beat();
  }
  std::uint64_t beats_seen() override {
    return other_.ring.control->beats.load(std::memory_order_relaxed);
  }
  Loss loss() override {
    if (pair_->inherited.load(std::memory_order_relaxed)) return Loss::Broken;
    return other_.closed.load(std::memory_order_acquire) ? Loss::Closed : Loss::None;
  }
  std::string loss_text() const override {
    if (pair_->inherited.load(std::memory_order_relaxed)) {
      return "this connection belongs to the process that forked this one: make a new connection";
    }
    return other_.closed.load(std::memory_order_acquire) ? "the other end closed the connection"
                                                         : "";
  }

  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return make_ring(largest, depth);
  }
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override {
    if (loss() != Loss::None) return tl::unexpected(SendProblem::Lost);
    auto& ring = dynamic_cast<StreamRingWriter&>(stream);
    {
      const MutexLock lock(pair_->mutex);
      pair_->streams[side_][id] = {ring.memory(), ring.owner()};
    }
    if (const auto list = shared_[id].lock()) list->remove(sleeper_.get());
    shared_[id] = ring.sleepers();
    ring.sleepers()->add(sleeper_);
    other_.wake_if_asleep();
    return {};
  }
  void unshare(std::uint32_t id) override {
    {
      const MutexLock lock(pair_->mutex);
      pair_->streams[side_].erase(id);
    }
    const auto held = shared_.extract(id);
    if (held.empty()) return;
    if (const auto list = held.mapped().lock()) list->remove(sleeper_.get());
  }
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id,
                                            const StreamBounds& /*most*/) override {
    const MutexLock lock(pair_->mutex);
    const auto& streams = pair_->streams[1 - side_];
    const auto found = streams.find(id);
    if (found == streams.end()) return nullptr;
    return watches_.open(found->second.memory, found->second.owner);
  }

 private:
  void wake_reader() {
    if (!writer_.reader_sleeps()) return;
    note_ring(*own_.ring.control);
    other_.event.notify();
  }

  const std::shared_ptr<SidePair> pair_;
  const std::size_t side_;
  Side& own_;
  Side& other_;
  RingWriter writer_;
  InprocAreas areas_;
  BulkWriter bulk_;
  RingReader reader_;
  StreamWatches watches_;
  const std::shared_ptr<SideSleeper> sleeper_;
  std::map<std::uint32_t, std::weak_ptr<SleeperList>> shared_;
  const std::array<int, 1> descriptors_;
  const Peer peer_;
};

/// The clients that have connected to an address and that its acceptor has not accepted yet.
struct Backlog {
  Mutex mutex;
  std::deque<std::shared_ptr<SidePair>> waiting GECOS_GUARDED_BY(mutex);
  EventFd event;  // drained and notified under `mutex`: readable while a client may wait
};

/// The backlog of each address at which this process listens. (The medium shm finds an address in
/// the file system instead.) A forked child does not listen at the addresses of its parent.
struct Backlogs {
  Mutex mutex;
  std::map<std::string, std::weak_ptr<Backlog>, std::less<>> by_address GECOS_GUARDED_BY(mutex);
  std::uint64_t opened GECOS_GUARDED_BY(mutex) = 0;

  static Backlogs& of_this_process();
};

Backlogs& Backlogs::of_this_process() {
  static constinit PerProcess<Backlogs> backlogs;
  return backlogs.get();
}

class InprocAcceptor final : public Acceptor {
 public:
  InprocAcceptor(Backlogs& backlogs, std::shared_ptr<Backlog> backlog, std::string address)
      : backlogs_(backlogs),
        backlog_(std::move(backlog)),
        address_(std::move(address)),
        descriptors_{backlog_->event.descriptor()} {}
  ~InprocAcceptor() override {
    if (&backlogs_ != &Backlogs::of_this_process()) return;  // a forked child closes nothing
    {
      const MutexLock lock(backlogs_.mutex);
      backlogs_.by_address.erase(address_);
    }
    while (accept() != nullptr) {  // closes the connections of clients that still wait
    }
  }

  const Capabilities& capabilities() const override { return inproc_capabilities; }
  const std::string& address() const override { return address_; }
  std::unique_ptr<Connection> accept() override {
    const MutexLock lock(backlog_->mutex);
    if (backlog_->waiting.empty()) {
      backlog_->event.drain();
      return nullptr;
    }
    auto pair = std::move(backlog_->waiting.front());
    backlog_->waiting.pop_front();
    return std::make_unique<InprocConnection>(std::move(pair), 1);
  }
  std::span<const int> descriptors() const override { return descriptors_; }
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return make_ring(largest, depth);
  }

 private:
  Backlogs& backlogs_;
  const std::shared_ptr<Backlog> backlog_;
  const std::string address_;
  const std::array<int, 1> descriptors_;
};

class Inproc final : public Medium {
 public:
  const Capabilities& capabilities() const override { return inproc_capabilities; }

  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    Backlogs& backlogs = Backlogs::of_this_process();
    auto backlog = std::make_shared<Backlog>();
    const MutexLock lock(backlogs.mutex);
    std::string address = well_known_address(name);
    if (!well_known) address += "." + std::to_string(++backlogs.opened);
    auto& held = backlogs.by_address[address];
    if (held.lock() != nullptr) {
      return tl::unexpected(MediumError{address + " is served already in this process"});
    }
    held = backlog;
    return std::make_unique<InprocAcceptor>(backlogs, std::move(backlog), std::move(address));
  }

  tl::expected<std::unique_ptr<Connection>, MediumError> connect(
      std::string_view address) override {
    Backlogs& backlogs = Backlogs::of_this_process();
    std::shared_ptr<Backlog> backlog;
    const MutexLock lock(backlogs.mutex);
    if (const auto found = backlogs.by_address.find(address); found != backlogs.by_address.end()) {
      backlog = found->second.lock();
    }
    if (backlog == nullptr) {
      return tl::unexpected(
          MediumError{std::string(address) + ": no server in this process has this address"});
    }
    auto pair = std::make_shared<SidePair>();
    {
      const MutexLock backlog_lock(backlog->mutex);
      backlog->waiting.push_back(pair);
      backlog->event.notify();
    }
    return std::make_unique<InprocConnection>(std::move(pair), 0);
  }

  std::string well_known_address(std::string_view name) const override {
    return "inproc:" + std::string(name);
  }
};

}  // namespace

std::unique_ptr<Medium> make_inproc() { return std::make_unique<Inproc>(); }

const Registration inproc_registration{
    inproc_capabilities,
    []() -> tl::expected<std::unique_ptr<Medium>, MediumError> { return make_inproc(); }};

}  // namespace gecos::media
