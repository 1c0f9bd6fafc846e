#include "pair_medium.hpp"

#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <deque>
#include <map>
#include <mutex>
#include <utility>

#include "gecos/base/descriptor.hpp"
#include "gecos/base/event_fd.hpp"
#include "gecos/base/fork_watch.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/media/buffers/mapping.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "pair_sockets.hpp"

namespace gecos::media {
namespace {

struct PairSamples {
  StreamMemory memory;
  std::shared_ptr<void> owner;
};

/// What one end has and the other one looks at.
struct PairSide {
  explicit PairSide(Descriptor of) : socket(std::move(of)) {}

  void wake_if_asleep() {
    if (asleep.load(std::memory_order_seq_cst)) event.notify();
  }

  Descriptor socket;
  EventFd event;                        // this side sleeps on it besides the socket
  std::atomic<bool> asleep{false};      // tells the other side to notify
  std::atomic<bool> closed{false};      // tells the other side
  std::atomic<std::uint64_t> beats{0};  // counts for the other side
};

/// Both ends; lives as long as one of them.
struct PairLine {
  explicit PairLine(SocketPair sockets)
      : sides{PairSide(std::move(sockets.one)), PairSide(std::move(sockets.other))} {}

  std::array<PairSide, 2> sides;
  std::mutex mutex;
  std::array<std::map<std::uint32_t, PairSamples>, 2> streams;  // that each side shares
  std::atomic<bool> inherited{false};  // this is a forked child: tells both ends
  ForkWatch watch{
      this, [](void* owner) noexcept { static_cast<PairLine*>(owner)->inherited.store(true); }};
};

class PairSleeper final : public Sleeper {
 public:
  PairSleeper(std::shared_ptr<PairLine> line, std::size_t side)
      : line_(std::move(line)), side_(side) {}
  void wake_if_asleep() override { line_->sides[side_].wake_if_asleep(); }

 private:
  const std::shared_ptr<PairLine> line_;
  const std::size_t side_;
};

std::unique_ptr<StreamWriter> make_samples(std::size_t largest, std::size_t depth) {
  auto mapping = std::make_shared<Mapping>(Mapping::anonymous(StreamMemory::bytes(largest, depth)));
  const StreamMemory memory{mapping->data(), largest, depth};
  return std::make_unique<StreamRingWriter>(memory, std::move(mapping));
}

class PairConnection final : public Connection {
 public:
  PairConnection(std::shared_ptr<PairLine> line, std::size_t side)
      : line_(std::move(line)),
        side_(side),
        own_(line_->sides[side]),
        other_(line_->sides[1 - side]),
        sleeper_(std::make_shared<PairSleeper>(line_, 1 - side)),
        descriptors_{own_.socket.get(), own_.event.descriptor()} {}
  ~PairConnection() override {
    for (const auto& [id, sleepers] : shared_) {
      if (const auto list = sleepers.lock()) list->remove(sleeper_.get());
    }
    if (inherited()) return;
    own_.closed.store(true);
    other_.event.notify();
  }

  const Capabilities& capabilities() const override { return pair_capabilities; }
  const Peer& peer() const override { return peer_; }

  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override {
    if (head.size() + body.size() > capabilities().largest_packet) {
      return tl::unexpected(SendProblem::TooLarge);
    }
    if (loss() != Loss::None) return tl::unexpected(SendProblem::Lost);
    if (!send_datagram(own_.socket.get(), head, body)) return tl::unexpected(SendProblem::Full);
    return ++sent_;
  }
  std::optional<ByteView> receive() override {
    if (inherited()) return std::nullopt;
    return receive_datagram(own_.socket.get(), packet_);
  }
  std::optional<std::uint64_t> taken_by_peer() override { return std::nullopt; }

  bool prepare_to_sleep() override {
    own_.asleep.store(true, std::memory_order_seq_cst);
    if (!has_datagram(own_.socket.get()) && !watches_.anything_new() && loss() == Loss::None) {
      return true;
    }
    own_.asleep.store(false);
    return false;
  }
  void woke() override {
    own_.asleep.store(false);
    if (!inherited()) own_.event.drain();
  }
  std::span<const int> descriptors() const override { return descriptors_; }

  void beat() override { own_.beats.fetch_add(1); }
  std::uint64_t beats_seen() override { return other_.beats.load(); }
  Loss loss() override {
    if (inherited()) return Loss::Broken;
    return other_.closed.load() ? Loss::Closed : Loss::None;
  }
  std::string loss_text() const override {
    if (inherited()) return "this connection belongs to the process that forked this one";
    return other_.closed.load() ? "the other end closed the connection" : "";
  }

  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return make_samples(largest, depth);
  }
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override {
    if (loss() != Loss::None) return tl::unexpected(SendProblem::Lost);
    auto& ring = dynamic_cast<StreamRingWriter&>(stream);
    {
      const std::lock_guard lock(line_->mutex);
      line_->streams[side_][id] = {ring.memory(), ring.owner()};
    }
    if (const auto list = shared_[id].lock()) list->remove(sleeper_.get());
    shared_[id] = ring.sleepers();
    ring.sleepers()->add(sleeper_);
    other_.event.notify();
    return {};
  }
  void unshare(std::uint32_t id) override {
    const std::lock_guard lock(line_->mutex);
    line_->streams[side_].erase(id);
    const auto held = shared_.extract(id);
    if (held.empty()) return;
    if (const auto list = held.mapped().lock()) list->remove(sleeper_.get());
  }
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id,
                                            const StreamBounds& /*most*/) override {
    const std::lock_guard lock(line_->mutex);
    const auto& streams = line_->streams[1 - side_];
    const auto found = streams.find(id);
    if (found == streams.end()) return nullptr;
    return watches_.open(found->second.memory, found->second.owner);
  }

 private:
  bool inherited() const { return line_->inherited.load(); }

  const std::shared_ptr<PairLine> line_;
  const std::size_t side_;
  PairSide& own_;
  PairSide& other_;
  const std::shared_ptr<PairSleeper> sleeper_;
  const std::array<int, 2> descriptors_;
  const Peer peer_{{}, {}, "this process"};
  std::uint64_t sent_ = 0;
  Bytes packet_;
  StreamWatches watches_;
  std::map<std::uint32_t, std::weak_ptr<SleeperList>> shared_;
};

/// Where clients of one acceptor wait.
struct PairBacklog {
  std::mutex mutex;
  std::deque<std::shared_ptr<PairLine>> waiting;
  EventFd event;
};

class PairAcceptor final : public Acceptor {
 public:
  PairAcceptor(std::shared_ptr<PairBacklog> backlog, std::string address)
      : backlog_(std::move(backlog)),
        address_(std::move(address)),
        descriptors_{backlog_->event.descriptor()} {}
  ~PairAcceptor() override {
    while (accept() != nullptr) {  // a client that still waits sees the connection closed
    }
  }

  const Capabilities& capabilities() const override { return pair_capabilities; }
  const std::string& address() const override { return address_; }
  std::unique_ptr<Connection> accept() override {
    const std::lock_guard lock(backlog_->mutex);
    if (backlog_->waiting.empty()) {
      backlog_->event.drain();
      return nullptr;
    }
    auto line = std::move(backlog_->waiting.front());
    backlog_->waiting.pop_front();
    return std::make_unique<PairConnection>(std::move(line), 1);
  }
  std::span<const int> descriptors() const override { return descriptors_; }
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return make_samples(largest, depth);
  }

 private:
  const std::shared_ptr<PairBacklog> backlog_;
  const std::string address_;
  const std::array<int, 1> descriptors_;
};

class PairMedium final : public Medium {
 public:
  const Capabilities& capabilities() const override { return pair_capabilities; }

  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    std::string address = well_known_address(name);
    if (!well_known) address += "." + std::to_string(++opened_);
    auto& held = places_[address];
    if (held.lock() != nullptr) return tl::unexpected(MediumError{address + " is served already"});
    auto backlog = std::make_shared<PairBacklog>();
    held = backlog;
    return std::make_unique<PairAcceptor>(std::move(backlog), std::move(address));
  }

  tl::expected<std::unique_ptr<Connection>, MediumError> connect(
      std::string_view address) override {
    const auto found = places_.find(address);
    const auto backlog = found == places_.end() ? nullptr : found->second.lock();
    if (backlog == nullptr) {
      return tl::unexpected(
          MediumError{std::string(address) + ": no server listens at this address"});
    }
    auto sockets = SocketPair::open();
    if (!sockets) return tl::unexpected(MediumError{"pair: " + system_text(errno)});
    auto line = std::make_shared<PairLine>(std::move(*sockets));
    const std::lock_guard lock(backlog->mutex);
    backlog->waiting.push_back(line);
    backlog->event.notify();
    return std::make_unique<PairConnection>(std::move(line), 0);
  }

  std::string well_known_address(std::string_view name) const override {
    return "pair:" + std::string(name);
  }

 private:
  std::map<std::string, std::weak_ptr<PairBacklog>, std::less<>> places_;
  std::uint64_t opened_ = 0;
};

}  // namespace

std::unique_ptr<Medium> make_pair_medium() { return std::make_unique<PairMedium>(); }

}  // namespace gecos::media
