#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "gecos/media/medium.hpp"

/// The media by their kind, for those who must not know how each of them works.
namespace gecos::media {

/// What is used in place of a medium.
using WrapMedium = std::function<std::unique_ptr<Medium>(std::unique_ptr<Medium>)>;

/// Opens a medium with its usual settings, or says why it cannot be used here. `wrap` null: the
/// medium itself. Of one that may damage packets none arrives damaged: they are checked.
tl::expected<std::unique_ptr<Medium>, MediumError> open(Kind kind, const WrapMedium& wrap = {});

/// Equal exactly where programs reach each other over shm; a text of its own where shm is unusable.
std::string host_identity();

/// Whether two host identities are of one machine: where they differ, their directories do.
bool on_one_machine(std::string_view one, std::string_view other);

}  // namespace gecos::media
