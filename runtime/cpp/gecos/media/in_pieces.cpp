#include "gecos/media/in_pieces.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#include "gecos/media/transfer.hpp"

namespace gecos::media {
namespace {

Offer offer_of(const Medium& inner) {
  Offer offer = inner.offer();
  offer.ordered = false;  // small packets overtake large ones
  offer.largest_packet = largest_transfer;
  return offer;
}

class LinkInPieces final : public Link {
 public:
  LinkInPieces(std::unique_ptr<Link> inner, const Offer& offer, const Clock& clock)
      : inner_(std::move(inner)), offer_(offer), clock_(clock) {}

  const Offer& offer() const override { return offer_; }
  const Peer& peer() const override { return inner_->peer(); }

  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override {
    const std::size_t size = head.size() + body.size();
    if (size > largest_transfer) return tl::unexpected(SendProblem::TooLarge);
    const std::lock_guard lock(mutex_);
    if (size <= piece_bytes) {
      const auto sent = inner_->send(head, body);
      if (!sent) return sent;
      return ++sent_;
    }
    if (inner_->loss() != Loss::None) return tl::unexpected(SendProblem::Lost);
    // One that arrived and is sent again was not taken up: it was too old by then, say.
    const bool under_way = transfer_ && !transfer_->complete();
    if (!under_way || !is_packet(transfer_->packet(), head, body)) {
      if (under_way) return tl::unexpected(SendProblem::Full);
      Bytes packet(head.begin(), head.end());
      packet.insert(packet.end(), body.begin(), body.end());
      transfer_.emplace(++transfers_, std::move(packet));
    }
    advance();
    return ++sent_;
  }

  std::optional<ByteView> receive() override {
    while (const auto packet = inner_->receive()) {
      if (const auto piece = Piece::read(*packet)) {
        take(*piece);
        if (auto whole = incoming_.whole()) {
          current_ = std::move(*whole);
          return ByteView(current_);
        }
      } else if (const auto received = Received::read(*packet)) {
        const std::lock_guard lock(mutex_);
        if (transfer_) transfer_->take(*received, clock_.now());
        advance();
      } else {
        return packet;
      }
    }
    return std::nullopt;
  }

  Duration age() override { return inner_->age(); }  // of a large one: of its last piece
  std::optional<std::uint64_t> taken_by_peer() override { return std::nullopt; }
  bool arm() override { return inner_->arm(); }
  void disarm() override { inner_->disarm(); }
  std::span<const int> descriptors() const override { return inner_->descriptors(); }
  void beat() override {
    inner_->beat();
    const std::lock_guard lock(mutex_);
    advance();
  }
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
  static bool is_packet(ByteView known, ByteView head, ByteView body) {
    return known.size() == head.size() + body.size() &&
           std::ranges::equal(known.first(head.size()), head) &&
           std::ranges::equal(known.subspan(head.size()), body);
  }

  void take(const Piece& piece) {
    std::array<std::byte, Received::bytes> bytes;
    incoming_.take(piece).write(bytes);
    const std::lock_guard lock(mutex_);
    static_cast<void>(inner_->send(bytes, {}));  // lost, the piece comes again
  }

  /// With the mutex.
  void advance() {
    if (!transfer_ || transfer_->complete()) return;
    transfer_->advance(clock_.now(), [this](const Piece& piece) {
      std::array<std::byte, Piece::head_bytes> head;
      piece.write_head(head);
      static_cast<void>(inner_->send(head, piece.content));  // lost, it is sent again
    });
  }

  const std::unique_ptr<Link> inner_;
  const Offer offer_;
  const Clock& clock_;
  IncomingTransfers incoming_;  // of who receives
  Bytes current_;               // likewise
  std::mutex mutex_;            // guards what follows, and who sends
  std::optional<OutgoingTransfer> transfer_;  // under way, or the last that was
  std::uint64_t transfers_ = 0;
  std::uint64_t sent_ = 0;
};

class AcceptorInPieces final : public Acceptor {
 public:
  AcceptorInPieces(std::unique_ptr<Acceptor> inner, const Offer& offer, const Clock& clock)
      : inner_(std::move(inner)), offer_(offer), clock_(clock) {}

  const Offer& offer() const override { return offer_; }
  const std::string& address() const override { return inner_->address(); }
  std::unique_ptr<Link> accept() override {
    auto link = inner_->accept();
    if (link == nullptr) return nullptr;
    return std::make_unique<LinkInPieces>(std::move(link), offer_, clock_);
  }
  std::span<const int> descriptors() const override { return inner_->descriptors(); }
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return inner_->make_stream(largest, depth);
  }

 private:
  const std::unique_ptr<Acceptor> inner_;
  const Offer offer_;
  const Clock& clock_;
};

class InPieces final : public Medium {
 public:
  InPieces(std::unique_ptr<Medium> inner, const Clock& clock)
      : inner_(std::move(inner)), offer_(offer_of(*inner_)), clock_(clock) {}

  const Offer& offer() const override { return offer_; }
  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    auto acceptor = inner_->listen(name, well_known);
    if (!acceptor) return acceptor;
    return std::make_unique<AcceptorInPieces>(std::move(*acceptor), offer_, clock_);
  }
  tl::expected<std::unique_ptr<Link>, MediumError> connect(std::string_view address) override {
    auto link = inner_->connect(address);
    if (!link) return link;
    return std::make_unique<LinkInPieces>(std::move(*link), offer_, clock_);
  }
  std::string well_known_address(std::string_view name) const override {
    return inner_->well_known_address(name);
  }

 private:
  const std::unique_ptr<Medium> inner_;
  const Offer offer_;
  const Clock& clock_;
};

}  // namespace

std::unique_ptr<Medium> make_in_pieces(std::unique_ptr<Medium> inner, const Clock& clock) {
  return std::make_unique<InPieces>(std::move(inner), clock);
}

}  // namespace gecos::media
