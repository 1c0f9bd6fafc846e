#pragma once

#include <memory>

#include "gecos/base/clock.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// Wraps a medium that loses packets, or carries only small ones: packets up to `largest_transfer`
/// go through it. Those above a piece, as the medium's offer has it, go in pieces (transfer.hpp);
/// lost pieces are sent again until the other end has all. Both ends have to be wrapped.
///
/// A link has one large packet under way; for a second one it is Full. The one that is under way,
/// or was the last to arrive, is not sent again. Both ends' receive() and beat() keep it going.
std::unique_ptr<Medium> make_fragmented(std::unique_ptr<Medium> inner, const Clock& clock);

}  // namespace gecos::media
