#pragma once

#include <memory>
#include <string>

#include "gecos/media/medium.hpp"

/// The media by their kind, for those who must not know how each of them works.
namespace gecos::media {

/// Opens a medium with its usual settings, or says why it cannot be used here.
tl::expected<std::unique_ptr<Medium>, MediumError> open(Kind kind);

/// Equal exactly where programs reach each other over shm; a text of its own where shm is unusable.
std::string host_identity();

}  // namespace gecos::media
