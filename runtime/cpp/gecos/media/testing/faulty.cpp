#include "gecos/media/testing/faulty.hpp"

#include <sys/timerfd.h>

#include <algorithm>
#include <cerrno>
#include <deque>
#include <random>
#include <utility>
#include <vector>

#include "gecos/base/descriptor.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/media/layers/layer.hpp"

namespace gecos::media {
namespace {

Capabilities capabilities_of(const Medium& inner, const Faults& faults) {
  Capabilities capabilities = inner.capabilities();
  const bool whole = faults.loss == 0 && faults.duplication == 0 && faults.corruption == 0;
  capabilities.reliable = capabilities.reliable && whole && faults.cut == nullptr;
  // Cutting a connection does not stop writes to shared words. Therefore a connection that may be
  // cut must not offer shared words.
  capabilities.shared_words = capabilities.shared_words && capabilities.reliable;
  capabilities.ordered = capabilities.ordered && faults.reordering == 0;
  capabilities.intact = capabilities.intact && faults.corruption == 0;
  capabilities.real_time =
      capabilities.real_time && capabilities.reliable && faults.delay == Duration::zero();
  return capabilities;
}

class FaultyConnection final : public ConnectionLayer {
 public:
  FaultyConnection(std::unique_ptr<Connection> inner, const Capabilities& capabilities,
                   const Faults& faults, std::uint64_t number, const Clock& clock)
      : ConnectionLayer(std::move(inner), capabilities),
        faults_(faults),
        clock_(clock),
        random_(faults.seed * 0x9e3779b97f4a7c15u + number),
        timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)) {
    if (!timer_) throw_system_error("timerfd", errno);
    descriptors_.assign(ConnectionLayer::descriptors().begin(),
                        ConnectionLayer::descriptors().end());
    descriptors_.push_back(timer_.get());
  }

  std::optional<ByteView> receive() override {
    take_in();
    const auto next = earliest();
    if (next == held_.end() || next->due > clock_.now()) return std::nullopt;
    current_ = std::move(next->packet);
    sent_ = next->sent;
    held_.erase(next);
    return ByteView(current_);
  }

  Duration age() override { return clock_.now() - sent_; }

  /// If the faults can drop packets, the result is unknown, because the inner connection counts
  /// dropped packets as taken.
  std::optional<std::uint64_t> taken_by_peer() override {
    return capabilities().reliable ? inner().taken_by_peer() : std::nullopt;
  }

  bool prepare_to_sleep() override {
    take_in();
    const auto next = earliest();
    const Duration wait = next == held_.end() ? Duration::max() : next->due - clock_.now();
    if (wait <= Duration::zero()) return false;
    set_timer(next == held_.end() ? Duration::zero() : wait);
    if (inner().prepare_to_sleep()) return true;
    if (is_cut() && inner().loss() == Loss::None) {
      take_in();  // packets that a cut connection drops must not keep the thread awake
      return inner().prepare_to_sleep();
    }
    return false;
  }
  void woke() override {
    set_timer(Duration::zero());
    inner().woke();
  }
  std::span<const int> descriptors() const override { return descriptors_; }

  std::uint64_t beats_seen() override {
    if (!is_cut()) beats_.store(inner().beats_seen());
    return beats_.load();
  }
  std::uint64_t beats_read() override { return std::min(beats_seen(), inner().beats_read()); }

 private:
  struct Held {
    TimePoint due;
    TimePoint sent;
    Bytes packet;
  };

  bool is_cut() const { return faults_.cut != nullptr && faults_.cut->load(); }
  bool happens(double rate) { return std::uniform_real_distribution<>(0, 1)(random_) < rate; }

  void take_in() {
    while (const auto packet = inner().receive()) {
      if (is_cut() || happens(faults_.loss)) continue;
      const int copies = happens(faults_.duplication) ? 2 : 1;
      for (int i = 0; i < copies; ++i) hold(Bytes(packet->begin(), packet->end()));
    }
  }

  void hold(Bytes packet) {
    if (!packet.empty() && happens(faults_.corruption)) {
      const std::size_t bit = random_() % (8 * packet.size());
      packet[bit / 8] ^= std::byte{1} << (bit % 8);
    }
    const Duration more = happens(faults_.reordering) ? faults_.reordering_delay : Duration::zero();
    const TimePoint now = clock_.now();
    const Duration added(faults_.more_delay != nullptr ? faults_.more_delay->load() : 0);
    held_.push_back({now + faults_.delay + added + more, now - inner().age(), std::move(packet)});
  }

  /// Returns the held packet that is due first. If several packets are due at the same time,
  /// returns the packet that arrived first.
  std::deque<Held>::iterator earliest() { return std::ranges::min_element(held_, {}, &Held::due); }

  void set_timer(Duration after) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(after);
    const itimerspec once{
        {}, {static_cast<time_t>(seconds.count()), static_cast<long>((after - seconds).count())}};
    ::timerfd_settime(timer_.get(), 0, &once, nullptr);
  }

  const Faults faults_;
  const Clock& clock_;
  std::mt19937_64 random_;
  const Descriptor timer_;
  std::vector<int> descriptors_;
  std::deque<Held> held_;
  Bytes current_;
  TimePoint sent_{};
  std::atomic<std::uint64_t> beats_{0};
};

}  // namespace

std::unique_ptr<Medium> make_faulty(std::unique_ptr<Medium> inner, Faults faults,
                                    const Clock& clock) {
  const Capabilities layer_capabilities = capabilities_of(*inner, faults);
  // Connections of clients get even numbers, and connections of servers get odd numbers, so that no
  // two connections have the same faults.
  auto clients = std::make_shared<std::atomic<std::uint64_t>>(0);
  auto servers = std::make_shared<std::atomic<std::uint64_t>>(0);
  return make_layer(std::move(inner), layer_capabilities,
                    [=, &clock](std::unique_ptr<Connection> connection,
                                const Capabilities& capabilities, Role role) {
                      const std::uint64_t number = role == Role::Client
                                                       ? 2 * clients->fetch_add(1)
                                                       : 2 * servers->fetch_add(1) + 1;
                      return std::make_unique<FaultyConnection>(std::move(connection), capabilities,
                                                                faults, number, clock);
                    });
}

}  // namespace gecos::media
