#include "gecos/media/medium.hpp"

namespace gecos::media {

bool LentSample::intact() const {
  if (version == nullptr) return true;
  std::atomic_thread_fence(std::memory_order_acquire);  // orders the check after the reader's reads
  return version->load(std::memory_order_relaxed) == 2 * sequence;
}

void Connection::write_word(std::size_t /*index*/, std::uint64_t /*value*/) {}

std::uint64_t Connection::peer_word(std::size_t /*index*/) { return 0; }

Whereabouts Connection::peer_whereabouts() { return {}; }

std::string Connection::why_no_stream(std::uint32_t /*id*/) { return {}; }

tl::expected<std::unique_ptr<OpenChannel>, MediumError> Acceptor::open_channel(
    const std::string& /*name*/) {
  return nullptr;
}

}  // namespace gecos::media
