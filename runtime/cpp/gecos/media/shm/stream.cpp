#include "gecos/media/shm/stream.hpp"

#include <stdexcept>
#include <utility>

namespace gecos::media::shm {

std::unique_ptr<StreamWriter> make_shared_stream(std::size_t largest, std::size_t depth) {
  auto sealed = make_sealed("gecos stream", StreamMemory::bytes(largest, depth));
  if (!sealed) throw std::runtime_error(sealed.error().text);
  auto held = std::make_shared<SealedMemory>(std::move(*sealed));
  const StreamMemory memory{held->mapping.data(), largest, depth};
  return std::make_unique<SharedStreamWriter>(memory, std::move(held));
}

}  // namespace gecos::media::shm
