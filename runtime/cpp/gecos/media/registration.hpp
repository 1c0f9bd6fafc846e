#pragma once

#include <memory>

#include "gecos/media/kinds.hpp"

namespace gecos::media {

/// What is known about a medium before it is opened. The folder of a medium `x` defines
/// `x_registration`.
struct Registration {
  const Capabilities& capabilities;
  /// Opens the medium with its usual settings, or returns why it cannot be used here.
  tl::expected<std::unique_ptr<Medium>, MediumError> (*open)();
};

#define GECOS_DECLARE(kind, name) extern const Registration name##_registration;
GECOS_MEDIA(GECOS_DECLARE)
#undef GECOS_DECLARE

}  // namespace gecos::media
