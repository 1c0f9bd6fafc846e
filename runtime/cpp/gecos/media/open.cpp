#include "gecos/media/open.hpp"

#include "gecos/media/inproc.hpp"
#include "gecos/media/lcm.hpp"
#include "gecos/media/shm/shm.hpp"

namespace gecos::media {

tl::expected<std::unique_ptr<Medium>, MediumError> open(Kind kind) {
  switch (kind) {
    case Kind::Inproc: return make_inproc();
    case Kind::Shm: return make_shm();
    case Kind::Lcm: return make_lcm();
  }
  return tl::unexpected(MediumError{"this program does not know the medium"});
}

std::string host_identity() {
  const std::string directory = shm::default_runtime_directory();
  if (const auto prepared = shm::prepare_directory(directory); !prepared) {
    return "no shared memory: " + prepared.error().text;
  }
  const auto identity = shm::host_identity(directory);
  return identity ? *identity : "no shared memory: " + identity.error().text;
}

}  // namespace gecos::media
