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

std::optional<Kind> kind_from(std::string_view name) {
  for (const Kind kind : {Kind::Inproc, Kind::Shm, Kind::Lcm}) {
    if (to_string(kind) == name) return kind;
  }
  return std::nullopt;
}

}  // namespace gecos::media
