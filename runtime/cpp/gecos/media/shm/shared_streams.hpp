#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "gecos/media/medium.hpp"
#include "gecos/media/parts/stream_ring.hpp"
#include "gecos/media/shm/control.hpp"
#include "gecos/media/shm/control_queue.hpp"
#include "gecos/media/shm/memory.hpp"
#include "gecos/media/shm/peer_end.hpp"
#include "gecos/media/shm/stream.hpp"

namespace gecos::media::shm {

/// The streams that the two ends of a connection share with each other. Not thread-safe: the
/// connection's mutex guards it.
class SharedStreams {
 public:
  /// The maximum number of streams that this end may share, and that it accepts. A peer that shares
  /// more is hostile: each stream takes a mapping in the process that reads it.
  struct Limits {
    std::size_t shared = 0;
    std::size_t received = 0;
  };
  explicit SharedStreams(Limits limits) : limits_(limits) {}

  // Streams that this end publishes.
  tl::expected<void, SendProblem> share(std::uint32_t id, SharedStreamWriter& writer,
                                        const std::shared_ptr<PeerEnd>& reader, ControlQueue& to);
  void unshare(std::uint32_t id, PeerEnd& reader, ControlQueue& to);
  /// No stream wakes `reader` any more.
  void forget(PeerEnd& reader);

  // Streams that the peer publishes.
  /// Takes the memory in a Share message. Returns the error in the message, or nullopt.
  std::optional<std::string> received(ReceivedControl& control);
  /// Notes why the stream `id` cannot be opened. Returns false when there are too many streams.
  bool not_received(std::uint32_t id, std::string why);
  void withdrawn(std::uint32_t id);
  /// Null when the peer does not share the stream `id`.
  std::unique_ptr<StreamReader> open(std::uint32_t id, StreamWatches& watches) const;
  /// Why the stream `id` cannot be opened; empty when the peer has not shared it yet.
  std::string why_not_open(std::uint32_t id) const;

 private:
  struct Received {
    StreamMemory memory;
    std::shared_ptr<Mapping> mapping;
  };

  const Limits limits_;
  std::map<std::uint32_t, std::weak_ptr<SleeperList>> shared_;
  std::map<std::uint32_t, Received> received_;
  std::map<std::uint32_t, std::string> not_received_;  ///< why a shared stream cannot be opened
};

}  // namespace gecos::media::shm
