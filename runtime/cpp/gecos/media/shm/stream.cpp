#include "gecos/media/shm/stream.hpp"

#include <stdexcept>
#include <string>
#include <utility>

namespace gecos::media::shm {

namespace {

std::shared_ptr<SealedMemory> make_stream_memory(std::size_t largest, std::size_t depth) {
  auto sealed = make_sealed("gecos stream", StreamMemory::bytes(largest, depth));
  if (!sealed) throw std::runtime_error(sealed.error().text);
  return std::make_shared<SealedMemory>(std::move(*sealed));
}

}  // namespace

StreamPlace::Now StreamPlace::now() const {
  const MutexLock lock(mutex_);
  return now_;
}

void StreamPlace::move_to(std::shared_ptr<SealedMemory> memory) {
  const MutexLock lock(mutex_);
  now_ = {std::move(memory), now_.moves + 1};
}

void SharedStreamWriter::move_on() {
  auto held = make_stream_memory(memory().largest, memory().depth);
  move_to({held->mapping.data(), memory().largest, memory().depth}, held);
  place_->move_to(std::move(held));
}

std::unique_ptr<StreamWriter> make_shared_stream(std::size_t largest, std::size_t depth) {
  if (depth + 1 > StreamMemory::most_bytes / StreamMemory::slot_bytes(largest)) {
    throw std::runtime_error(
        std::to_string(depth) + " samples of " + std::to_string(largest) +
        " bytes take more than 1 GiB; reduce the depth in the @qos of the stream");
  }
  auto held = make_stream_memory(largest, depth);
  const StreamMemory memory{held->mapping.data(), largest, depth};
  return std::make_unique<SharedStreamWriter>(memory, std::move(held));
}

}  // namespace gecos::media::shm
