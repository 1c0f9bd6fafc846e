#include "gecos/media/open.hpp"

#include <charconv>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "gecos/media/checked.hpp"
#include "gecos/media/in_pieces.hpp"
#include "gecos/media/inproc.hpp"
#include "gecos/media/lcm.hpp"
#include "gecos/media/shm/shm.hpp"

namespace gecos::media {
namespace {

tl::expected<std::unique_ptr<Medium>, MediumError> open_lcm() {
  LcmOptions options;
  if (const char* const set = std::getenv("GECOS_LCM_TTL"); set != nullptr && *set != '\0') {
    const std::string_view text(set);
    const auto [end, failed] = std::from_chars(text.begin(), text.end(), options.ttl);
    if (failed != std::errc{} || end != text.end() || options.ttl < 0 || options.ttl > 255) {
      return tl::unexpected(
          MediumError{"lcm: GECOS_LCM_TTL is '" + std::string(text) +
                      "'; it says how many routers a packet may pass, 0 (this host alone) to 255"});
    }
  }
  return make_lcm(options);
}

tl::expected<std::unique_ptr<Medium>, MediumError> open_shm() {
  const ShmOptions options;
  return shm::prepare_directory(options.directory).map([&] { return make_shm(options); });
}

tl::expected<std::unique_ptr<Medium>, MediumError> open_itself(Kind kind) {
  switch (kind) {
    case Kind::Inproc:
      return make_inproc();
    case Kind::Shm:
      return open_shm();
    case Kind::Lcm:
      return open_lcm();
  }
  return tl::unexpected(MediumError{"this program does not know the medium"});
}

}  // namespace

tl::expected<std::unique_ptr<Medium>, MediumError> open(Kind kind, const WrapMedium& wrap) {
  auto opened = open_itself(kind);
  if (opened && wrap) opened = wrap(std::move(*opened));
  if (opened && !(*opened)->offer().intact) opened = make_checked(std::move(*opened));
  static const SystemClock clock;
  if (opened && kind == Kind::Lcm) opened = make_in_pieces(std::move(*opened), clock);
  return opened;
}

std::string host_identity() {
  const std::string directory = shm::default_runtime_directory();
  if (const auto prepared = shm::prepare_directory(directory); !prepared) {
    return "no shared memory: " + prepared.error().text;
  }
  const auto identity = shm::host_identity(directory);
  return identity ? *identity : "no shared memory: " + identity.error().text;
}

bool on_one_machine(std::string_view one, std::string_view other) {
  const auto boot = one.substr(0, one.find('/'));
  return boot.size() < one.size() && other.starts_with(boot) && other.substr(boot.size(), 1) == "/";
}

}  // namespace gecos::media
