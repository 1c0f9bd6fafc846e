#include "gecos/media/medium.hpp"

namespace gecos::media {

void Link::write_word(std::size_t /*index*/, std::uint64_t /*value*/) {}

std::uint64_t Link::peer_word(std::size_t /*index*/) { return 0; }

Whereabouts Link::peer_whereabouts() { return {}; }

std::string Link::why_no_stream(std::uint32_t /*id*/) { return {}; }

}  // namespace gecos::media
