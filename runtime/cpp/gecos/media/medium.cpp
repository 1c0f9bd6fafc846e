#include "gecos/media/medium.hpp"

namespace gecos::media {

std::string_view to_string(Kind kind) {
  switch (kind) {
    case Kind::Inproc:
      return "inproc";
    case Kind::Shm:
      return "shm";
    case Kind::Lcm:
      return "lcm";
  }
  return "unknown medium";
}

void Link::write_word(std::size_t /*index*/, std::uint64_t /*value*/) {}

std::uint64_t Link::peer_word(std::size_t /*index*/) { return 0; }

Whereabouts Link::peer_whereabouts() { return {}; }

std::string Link::why_no_stream(std::uint32_t /*id*/) { return {}; }

std::optional<Kind> kind_from(std::string_view name) {
  for (const Kind kind : {Kind::Inproc, Kind::Shm, Kind::Lcm}) {
    if (to_string(kind) == name) return kind;
  }
  return std::nullopt;
}

}  // namespace gecos::media
