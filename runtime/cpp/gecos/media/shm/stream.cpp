#include "gecos/media/shm/stream.hpp"

#include <stdexcept>
#include <string>
#include <utility>

namespace gecos::media::shm {

std::unique_ptr<StreamWriter> make_shared_stream(std::size_t largest, std::size_t depth) {
  if (depth + 1 > StreamMemory::most_bytes / StreamMemory::slot_bytes(largest)) {
    throw std::runtime_error(std::to_string(depth) + " samples of " + std::to_string(largest) +
                             " bytes take more than 1 GiB; reduce the depth in its @qos");
  }
  auto sealed = make_sealed("gecos stream", StreamMemory::bytes(largest, depth));
  if (!sealed) throw std::runtime_error(sealed.error().text);
  auto held = std::make_shared<SealedMemory>(std::move(*sealed));
  const StreamMemory memory{held->mapping.data(), largest, depth};
  return std::make_unique<SharedStreamWriter>(memory, std::move(held));
}

}  // namespace gecos::media::shm
