#include "gecos/media/faulty.hpp"

#include <sys/timerfd.h>

#include <algorithm>
#include <cerrno>
#include <deque>
#include <random>
#include <system_error>
#include <utility>
#include <vector>

#include "gecos/media/descriptor.hpp"

namespace gecos::media {
namespace {

Offer offer_of(const Medium& inner, const Faults& faults) {
  Offer offer = inner.offer();
  const bool whole = faults.loss == 0 && faults.duplication == 0 && faults.corruption == 0;
  offer.reliable = offer.reliable && whole && faults.cut == nullptr;
  offer.ordered = offer.ordered && faults.reordering == 0;
  offer.intact = offer.intact && faults.corruption == 0;
  offer.real_time = offer.real_time && offer.reliable && faults.delay == Duration::zero();
  return offer;
}

class FaultyLink final : public Link {
 public:
  FaultyLink(std::unique_ptr<Link> inner, const Offer& offer, const Faults& faults,
             std::uint64_t number, const Clock& clock)
      : inner_(std::move(inner)),
        offer_(offer),
        faults_(faults),
        clock_(clock),
        random_(faults.seed * 0x9e3779b97f4a7c15u + number),
        timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)) {
    if (!timer_) throw std::system_error(errno, std::generic_category(), "timerfd");
    descriptors_.assign(inner_->descriptors().begin(), inner_->descriptors().end());
    descriptors_.push_back(timer_.get());
  }

  const Offer& offer() const override { return offer_; }
  const Peer& peer() const override { return inner_->peer(); }
  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override {
    return inner_->send(head, body);
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

  /// What the medium below has taken may be lost here, so nothing is known.
  std::optional<std::uint64_t> taken_by_peer() override {
    return offer_.reliable ? inner_->taken_by_peer() : std::nullopt;
  }

  bool arm() override {
    take_in();
    const auto next = earliest();
    const Duration wait = next == held_.end() ? Duration::max() : next->due - clock_.now();
    if (wait <= Duration::zero()) return false;
    set_timer(next == held_.end() ? Duration::zero() : wait);
    if (inner_->arm()) return true;
    if (is_cut() && inner_->loss() == Loss::None) {
      take_in();  // what arrived through a cut line is gone, and no reason to stay awake
      return inner_->arm();
    }
    return false;
  }
  void disarm() override {
    set_timer(Duration::zero());
    inner_->disarm();
  }
  std::span<const int> descriptors() const override { return descriptors_; }

  void beat() override { inner_->beat(); }
  std::uint64_t beats_seen() override {
    if (!is_cut()) beats_.store(inner_->beats_seen());
    return beats_.load();
  }
  Loss loss() override { return inner_->loss(); }
  std::string loss_text() const override { return inner_->loss_text(); }
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override {
    return inner_->share(id, stream);
  }
  void unshare(std::uint32_t id) override { inner_->unshare(id); }
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id) override {
    return inner_->open_stream(id);
  }

 private:
  struct Held {
    TimePoint due;
    TimePoint sent;
    Bytes packet;
  };

  bool is_cut() const { return faults_.cut != nullptr && faults_.cut->load(); }
  bool happens(double rate) { return std::uniform_real_distribution<>(0, 1)(random_) < rate; }

  void take_in() {
    while (const auto packet = inner_->receive()) {
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
    const Duration more =
        happens(faults_.reordering) ? faults_.reordering_delay : Duration::zero();
    const TimePoint now = clock_.now();
    held_.push_back({now + faults_.delay + more, now - inner_->age(), std::move(packet)});
  }

  /// Of those that are due at one time the first comes first.
  std::deque<Held>::iterator earliest() {
    return std::ranges::min_element(held_, {}, &Held::due);
  }

  void set_timer(Duration after) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(after);
    const itimerspec once{
        {}, {static_cast<time_t>(seconds.count()), static_cast<long>((after - seconds).count())}};
    ::timerfd_settime(timer_.get(), 0, &once, nullptr);
  }

  const std::unique_ptr<Link> inner_;
  const Offer offer_;
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

class FaultyAcceptor final : public Acceptor {
 public:
  FaultyAcceptor(std::unique_ptr<Acceptor> inner, const Offer& offer, const Faults& faults,
                 const Clock& clock)
      : inner_(std::move(inner)), offer_(offer), faults_(faults), clock_(clock) {}

  const Offer& offer() const override { return offer_; }
  const std::string& address() const override { return inner_->address(); }
  std::unique_ptr<Link> accept() override {
    auto link = inner_->accept();
    if (link == nullptr) return nullptr;
    // Odd numbers here, even ones at the clients: no two links suffer alike.
    return std::make_unique<FaultyLink>(std::move(link), offer_, faults_, 2 * accepted_++ + 1,
                                        clock_);
  }
  std::span<const int> descriptors() const override { return inner_->descriptors(); }
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return inner_->make_stream(largest, depth);
  }

 private:
  const std::unique_ptr<Acceptor> inner_;
  const Offer offer_;
  const Faults faults_;
  const Clock& clock_;
  std::uint64_t accepted_ = 0;
};

class Faulty final : public Medium {
 public:
  Faulty(std::unique_ptr<Medium> inner, Faults faults, const Clock& clock)
      : inner_(std::move(inner)),
        faults_(faults),
        offer_(offer_of(*inner_, faults)),
        clock_(clock) {}

  const Offer& offer() const override { return offer_; }
  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    auto acceptor = inner_->listen(name, well_known);
    if (!acceptor) return acceptor;
    return std::make_unique<FaultyAcceptor>(std::move(*acceptor), offer_, faults_, clock_);
  }
  tl::expected<std::unique_ptr<Link>, MediumError> connect(std::string_view address) override {
    auto link = inner_->connect(address);
    if (!link) return link;
    return std::make_unique<FaultyLink>(std::move(*link), offer_, faults_,
                                        2 * connected_.fetch_add(1), clock_);
  }
  std::string well_known_address(std::string_view name) const override {
    return inner_->well_known_address(name);
  }

 private:
  const std::unique_ptr<Medium> inner_;
  const Faults faults_;
  const Offer offer_;
  const Clock& clock_;
  std::atomic<std::uint64_t> connected_{0};
};

}  // namespace

std::unique_ptr<Medium> make_faulty(std::unique_ptr<Medium> inner, Faults faults,
                                    const Clock& clock) {
  return std::make_unique<Faulty>(std::move(inner), faults, clock);
}

}  // namespace gecos::media
