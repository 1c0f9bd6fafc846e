#pragma once

#include <memory>

#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/media/shm/memory.hpp"

namespace gecos::media::shm {

/// The writer of a stream in sealed memory that only this stream uses. Every connection that shares
/// the stream sends the descriptor of the memory to its peer.
class SharedStreamWriter final : public StreamRingWriter {
 public:
  SharedStreamWriter(StreamMemory memory, std::shared_ptr<SealedMemory> sealed)
      : StreamRingWriter(memory, sealed), sealed_(std::move(sealed)) {}
  const std::shared_ptr<SealedMemory>& sealed() const { return sealed_; }

 private:
  const std::shared_ptr<SealedMemory> sealed_;
};

/// Makes a stream in shared memory. Throws std::runtime_error when no memory or no descriptor is
/// left.
std::unique_ptr<StreamWriter> make_shared_stream(std::size_t largest, std::size_t depth);

}  // namespace gecos::media::shm
