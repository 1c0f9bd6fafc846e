#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "gecos/media/medium.hpp"

/// The media of this library by their names, for code that must not know how each of them works.
namespace gecos::media {

/// All media, the shortest reach first: the enumerator, and the name, which is also the folder. A
/// new medium is its folder and one line here (registration.hpp). Everything else asks Offer.
#define GECOS_MEDIA(MEDIUM) \
  MEDIUM(Inproc, inproc)    \
  MEDIUM(Shm, shm)          \
  MEDIUM(Lcm, lcm)

enum class Kind : std::uint8_t {
#define GECOS_ENUMERATOR(kind, name) kind,
  GECOS_MEDIA(GECOS_ENUMERATOR)
#undef GECOS_ENUMERATOR
};

std::string_view to_string(Kind kind);
std::optional<Kind> kind_from(std::string_view name);
/// The medium that an address names before its first ':'.
std::optional<Kind> kind_of(std::string_view address);
std::span<const Kind> all_kinds();
Reach reach_of(Kind kind);
/// Whether `kinds` is not empty and none of them leads out of this process.
bool within_process(std::span<const Kind> kinds);

/// Returns the medium to use in place of the given one.
using WrapMedium = std::function<std::unique_ptr<Medium>(std::unique_ptr<Medium>)>;

/// Opens a medium with its usual settings and the layers that it needs, or says why it cannot be
/// used here. `wrap` null: the medium itself.
tl::expected<std::unique_ptr<Medium>, MediumError> open(Kind kind, const WrapMedium& wrap = {});

/// Puts on `medium` the layers that its offer asks for: checksums where packets may be damaged,
/// pieces where the largest packet of the session does not fit.
std::unique_ptr<Medium> with_layers(std::unique_ptr<Medium> medium, const Clock& clock);

/// Equal exactly where programs reach each other over shm; a text of its own where shm is unusable.
std::string host_identity();

/// Whether two host identities are of one machine: where they differ, their directories do.
bool on_one_machine(std::string_view one, std::string_view other);

}  // namespace gecos::media
