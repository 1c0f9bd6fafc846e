#include "gecos/media/layers/fragments.hpp"

#include <algorithm>
#include <utility>

#include "gecos/base/mutex.hpp"
#include "gecos/media/layers/layer.hpp"
#include "gecos/media/layers/transfer.hpp"

namespace gecos::media {
namespace {

std::size_t piece_of(const Capabilities& capabilities) {
  const std::size_t fits = capabilities.largest_packet - Piece::head_bytes;
  return capabilities.piece == 0 ? fits : std::min(capabilities.piece, fits);
}

Capabilities fragmented_capabilities(const Medium& inner) {
  Capabilities capabilities = inner.capabilities();
  capabilities.ordered = false;  // a small packet may arrive before a large packet sent earlier
  capabilities.largest_packet = largest_transfer;
  return capabilities;
}

/// A connection that splits large packets into pieces. For a large packet, age() returns the age of
/// the piece that arrived last.
class FragmentedConnection final : public ConnectionLayer {
 public:
  FragmentedConnection(std::unique_ptr<Connection> inner, const Capabilities& capabilities,
                       const Clock& clock)
      : ConnectionLayer(std::move(inner), capabilities),
        piece_bytes_(piece_of(this->inner().capabilities())),
        clock_(clock),
        incoming_(piece_bytes_) {}

  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override {
    const std::size_t size = head.size() + body.size();
    if (size > largest_transfer) return tl::unexpected(SendProblem::TooLarge);
    const MutexLock lock(mutex_);
    if (size <= piece_bytes_) {
      const auto sent = inner().send(head, body);
      if (!sent) return sent;
      return ++sent_;
    }
    if (inner().loss() != Loss::None) return tl::unexpected(SendProblem::Lost);
    // If the caller sends a packet again after its transfer is complete, the packet is transferred
    // again: the peer received the packet but did not accept it, for example because it was too
    // old.
    const bool under_way = transfer_ && !transfer_->complete();
    if (!under_way || !is_packet(transfer_->packet(), head, body)) {
      if (under_way) return tl::unexpected(SendProblem::Full);
      Bytes packet(head.begin(), head.end());
      packet.insert(packet.end(), body.begin(), body.end());
      transfer_.emplace(++transfers_, std::move(packet), piece_bytes_);
    }
    advance();
    return ++sent_;
  }

  std::optional<ByteView> receive() override {
    while (const auto packet = inner().receive()) {
      if (const auto piece = Piece::read(*packet, piece_bytes_)) {
        take(*piece);
        if (auto whole = incoming_.whole()) {
          current_ = std::move(*whole);
          return ByteView(current_);
        }
      } else if (const auto received = Received::read(*packet)) {
        const MutexLock lock(mutex_);
        if (transfer_) transfer_->take(*received, clock_.now());
        advance();
      } else {
        return packet;
      }
    }
    return std::nullopt;
  }

  std::optional<std::uint64_t> taken_by_peer() override { return std::nullopt; }
  void beat() override {
    inner().beat();
    const MutexLock lock(mutex_);
    advance();
  }

  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    const MutexLock lock(mutex_);
    return inner().make_stream(largest, depth);
  }
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override {
    const MutexLock lock(mutex_);
    return inner().share(id, stream);
  }
  void unshare(std::uint32_t id) override {
    const MutexLock lock(mutex_);
    inner().unshare(id);
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
    const MutexLock lock(mutex_);
    // The result of send() is ignored, because the peer sends the piece again if this
    // acknowledgement is lost.
    static_cast<void>(inner().send(bytes, {}));
  }

  void advance() GECOS_REQUIRES(mutex_) {
    if (!transfer_ || transfer_->complete()) return;
    transfer_->advance(clock_.now(), [this](const Piece& piece) {
      std::array<std::byte, Piece::head_bytes> head;
      piece.write_head(head);
      static_cast<void>(inner().send(head, piece.content));  // a lost piece is sent again
    });
  }

  const std::size_t piece_bytes_;
  const Clock& clock_;
  IncomingTransfers incoming_;  // used by the receiving thread only
  Bytes current_;               // used by the receiving thread only
  /// This mutex is also held while inner() sends a packet, or makes or shares a stream. Only one
  /// thread at a time may call these functions of inner(), but in this layer the receiving thread
  /// and the maintenance thread also send packets.
  Mutex mutex_;
  /// The transfer of the large packet that is being sent now, or that was sent last.
  std::optional<OutgoingTransfer> transfer_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t transfers_ GECOS_GUARDED_BY(mutex_) = 0;
  std::uint64_t sent_ GECOS_GUARDED_BY(mutex_) = 0;
};

}  // namespace

std::unique_ptr<Medium> make_fragmented(std::unique_ptr<Medium> inner, const Clock& clock) {
  const Capabilities layer_capabilities = fragmented_capabilities(*inner);
  return make_layer(
      std::move(inner), layer_capabilities,
      [&clock](std::unique_ptr<Connection> connection, const Capabilities& capabilities, Role) {
        return std::make_unique<FragmentedConnection>(std::move(connection), capabilities, clock);
      });
}

}  // namespace gecos::media
