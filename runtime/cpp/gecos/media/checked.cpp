#include "gecos/media/checked.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace gecos::media {
namespace {

constexpr std::size_t check_size = sizeof(std::uint32_t);

constexpr std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t at = 0; at < table.size(); ++at) {
    std::uint32_t rest = at;
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1) ^ ((rest & 1) != 0 ? 0x82f63b78u : 0u);
    table[at] = rest;
  }
  return table;
}

Offer offer_of(const Medium& inner) {
  Offer offer = inner.offer();
  offer.intact = true;
  offer.largest_packet -= check_size;
  return offer;
}

class CheckedLink final : public Link {
 public:
  CheckedLink(std::unique_ptr<Link> inner, const Offer& offer)
      : inner_(std::move(inner)), offer_(offer) {}

  const Offer& offer() const override { return offer_; }
  const Peer& peer() const override { return inner_->peer(); }

  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override {
    if (head.size() + body.size() > offer_.largest_packet) {
      return tl::unexpected(SendProblem::TooLarge);
    }
    const std::uint32_t sum = crc32c(body, crc32c(head));
    std::array<std::byte, check_size> check;
    for (std::size_t at = 0; at < check_size; ++at) {
      check[at] = static_cast<std::byte>(sum >> (8 * (check_size - 1 - at)));
    }
    outgoing_.resize(check_size + head.size());
    std::ranges::copy(head, std::ranges::copy(check, outgoing_.begin()).out);
    return inner_->send(outgoing_, body);
  }

  std::optional<ByteView> receive() override {
    while (const auto packet = inner_->receive()) {
      if (packet->size() < check_size) continue;
      std::uint32_t sum = 0;
      for (const std::byte byte : packet->first(check_size)) {
        sum = sum << 8 | static_cast<std::uint32_t>(byte);
      }
      const ByteView rest = packet->subspan(check_size);
      if (crc32c(rest) == sum) return rest;
    }
    return std::nullopt;
  }

  Duration age() override { return inner_->age(); }
  std::optional<std::uint64_t> taken_by_peer() override { return inner_->taken_by_peer(); }
  bool arm() override { return inner_->arm(); }
  void disarm() override { inner_->disarm(); }
  std::span<const int> descriptors() const override { return inner_->descriptors(); }
  void beat() override { inner_->beat(); }
  std::uint64_t beats_seen() override { return inner_->beats_seen(); }
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
  const std::unique_ptr<Link> inner_;
  const Offer offer_;
  Bytes outgoing_;  ///< sending: reused
};

class CheckedAcceptor final : public Acceptor {
 public:
  CheckedAcceptor(std::unique_ptr<Acceptor> inner, const Offer& offer)
      : inner_(std::move(inner)), offer_(offer) {}

  const Offer& offer() const override { return offer_; }
  const std::string& address() const override { return inner_->address(); }
  std::unique_ptr<Link> accept() override {
    auto link = inner_->accept();
    if (link == nullptr) return nullptr;
    return std::make_unique<CheckedLink>(std::move(link), offer_);
  }
  std::span<const int> descriptors() const override { return inner_->descriptors(); }
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return inner_->make_stream(largest, depth);
  }

 private:
  const std::unique_ptr<Acceptor> inner_;
  const Offer offer_;
};

class Checked final : public Medium {
 public:
  explicit Checked(std::unique_ptr<Medium> inner)
      : inner_(std::move(inner)), offer_(offer_of(*inner_)) {}

  const Offer& offer() const override { return offer_; }
  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    auto acceptor = inner_->listen(name, well_known);
    if (!acceptor) return acceptor;
    return std::make_unique<CheckedAcceptor>(std::move(*acceptor), offer_);
  }
  tl::expected<std::unique_ptr<Link>, MediumError> connect(std::string_view address) override {
    auto link = inner_->connect(address);
    if (!link) return link;
    return std::make_unique<CheckedLink>(std::move(*link), offer_);
  }
  std::string well_known_address(std::string_view name) const override {
    return inner_->well_known_address(name);
  }

 private:
  const std::unique_ptr<Medium> inner_;
  const Offer offer_;
};

}  // namespace

std::uint32_t crc32c(ByteView bytes, std::uint32_t before) {
  static constexpr auto table = make_table();
  std::uint32_t sum = ~before;
  for (const std::byte byte : bytes) {
    sum = (sum >> 8) ^ table[(sum ^ static_cast<std::uint32_t>(byte)) & 0xff];
  }
  return ~sum;
}

std::unique_ptr<Medium> make_checked(std::unique_ptr<Medium> inner) {
  return std::make_unique<Checked>(std::move(inner));
}

}  // namespace gecos::media
