#pragma once

#include <cstdint>
#include <memory>

#include "gecos/base/mutex.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/media/shm/memory.hpp"

namespace gecos::media::shm {

/// The present memory of a stream, and how often the stream has moved to other memory. Thread-safe.
class StreamPlace {
 public:
  struct Now {
    std::shared_ptr<SealedMemory> memory;
    std::uint32_t moves = 0;
  };
  explicit StreamPlace(std::shared_ptr<SealedMemory> memory) : now_{std::move(memory), 0} {}

  Now now() const;
  void move_to(std::shared_ptr<SealedMemory> memory);

 private:
  mutable Mutex mutex_;
  Now now_ GECOS_GUARDED_BY(mutex_);
};

/// The writer of a stream in sealed memory that only this stream uses. Every connection that shares
/// the stream sends the descriptor of the memory to its peer.
class SharedStreamWriter final : public StreamRingWriter {
 public:
  SharedStreamWriter(StreamMemory memory, std::shared_ptr<SealedMemory> sealed)
      : StreamRingWriter(memory, sealed),
        place_(std::make_shared<StreamPlace>(std::move(sealed))) {}
  const std::shared_ptr<StreamPlace>& place() const { return place_; }
  /// Moves the stream to newly allocated memory, so that peers with the old memory get no further
  /// samples. The connections that share the stream send the descriptor of the new memory to their
  /// peers.
  void move_on() override;

 private:
  const std::shared_ptr<StreamPlace> place_;
};

/// Makes a stream in shared memory. Throws std::runtime_error when no memory or no descriptor is
/// left.
std::unique_ptr<StreamWriter> make_shared_stream(std::size_t largest, std::size_t depth);

}  // namespace gecos::media::shm
