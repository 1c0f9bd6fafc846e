#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/media/shm/control.hpp"
#include "gecos/media/shm/control_queue.hpp"
#include "gecos/media/shm/memory.hpp"
#include "gecos/media/shm/peer_end.hpp"
#include "gecos/media/shm/stream.hpp"

namespace gecos::media::shm {

/// The streams that the two ends of a connection share with each other. Not thread-safe; the mutex
/// of the connection guards this object.
class SharedStreams {
 public:
  /// The maximum number of streams that this end may share with the peer, and that it accepts from
  /// the peer. A peer that shares more streams is hostile, because each stream needs a mapping in
  /// the process that reads it.
  struct Limits {
    std::size_t shared = 0;
    std::size_t received = 0;
  };
  explicit SharedStreams(Limits limits) : limits_(limits) {}

  // The following functions are for streams that this end publishes.
  tl::expected<void, SendProblem> share(std::uint32_t id, SharedStreamWriter& writer,
                                        const std::shared_ptr<PeerEnd>& reader, ControlQueue& to);
  void unshare(std::uint32_t id, PeerEnd& reader, ControlQueue& to);
  /// Sends the peer the descriptor of the new memory of each stream that has moved.
  void follow_moves(ControlQueue& to);
  /// Removes `reader` from all streams, so that no stream wakes it any more.
  void forget(PeerEnd& reader);

  // The following functions are for streams that the peer publishes.

  /// Takes the memory of a stream from a Share message. Returns an error text when the message is
  /// invalid; otherwise nullopt. When this process has no address space left for the memory, the
  /// stream cannot be opened (see why_not_open).
  std::optional<std::string> received(ReceivedControl& control);
  /// Records why the stream `id` cannot be opened. Returns false when there are too many such
  /// streams.
  bool not_received(std::uint32_t id, std::string why);
  void withdrawn(std::uint32_t id);
  /// Opens the stream `id`. Returns null when the peer does not share this stream, or when its
  /// samples may be larger than `most`.
  std::unique_ptr<StreamReader> open(std::uint32_t id, const StreamBounds& most,
                                     StreamWatches& watches);
  /// Returns a text that says why the stream `id` cannot be opened. The text is empty when the peer
  /// has not shared the stream yet.
  std::string why_not_open(std::uint32_t id) const;

 private:
  struct Received {
    StreamMemory memory;
    std::shared_ptr<Mapping> mapping;
    std::vector<std::weak_ptr<StreamWatch>> readers{};

    bool is_read() const {
      return std::ranges::any_of(readers, [](const auto& one) { return !one.expired(); });
    }
  };
  struct Shared {
    std::weak_ptr<SleeperList> sleepers;
    std::weak_ptr<StreamPlace> place;
    ControlMessage announcement;
    std::uint32_t moves = 0;  ///< of the memory that the peer has
  };

  const Limits limits_;
  std::map<std::uint32_t, Shared> shared_;
  std::map<std::uint32_t, Received> received_;
  std::map<std::uint32_t, std::string> not_received_;  ///< why a shared stream cannot be opened
};

}  // namespace gecos::media::shm
