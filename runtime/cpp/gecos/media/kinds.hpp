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

/// All media, the shortest reach first. Each line has an enumerator and a name; the folder of the
/// medium has the same name. To add a medium, add its folder and one line here (registration.hpp).
/// Other code must check the Capabilities instead of the enumerator.
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
/// Whether `kinds` is not empty and all of them stay within this process.
bool within_process(std::span<const Kind> kinds);

/// Wraps a medium: returns the medium to use instead of the one that is passed.
using WrapMedium = std::function<std::unique_ptr<Medium>(std::unique_ptr<Medium>)>;

/// Opens a medium with its usual settings and the layers that it needs, or returns why it cannot be
/// used here. `wrap`, if set, is applied below these layers.
tl::expected<std::unique_ptr<Medium>, MediumError> open(Kind kind, const WrapMedium& wrap = {});

/// Wraps `medium` in the layers that its capabilities require: checksums if packets may be
/// damaged, fragmentation if the session's largest packet does not fit.
std::unique_ptr<Medium> with_layers(std::unique_ptr<Medium> medium, const Clock& clock);

/// A text that is equal in two programs if and only if they reach each other over shm. Where shm is
/// unusable, the text says why.
std::string host_identity();

/// Whether two host identities belong to one machine, possibly with different runtime directories.
bool on_one_machine(std::string_view one, std::string_view other);

}  // namespace gecos::media
