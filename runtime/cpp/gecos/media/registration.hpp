#pragma once

#include <memory>

#include "gecos/media/kinds.hpp"

namespace gecos::media {

/// The data of a medium that are needed before the medium is opened. For example, the folder of the
/// medium shm defines the variable `shm_registration`.
struct Registration {
  const Capabilities& capabilities;
  /// Opens the medium with its usual settings, or returns an error that says why it cannot be used
  /// here.
  tl::expected<std::unique_ptr<Medium>, MediumError> (*open)();
};

#define GECOS_DECLARE(kind, name) extern const Registration name##_registration;
GECOS_MEDIA(GECOS_DECLARE)
#undef GECOS_DECLARE

}  // namespace gecos::media
