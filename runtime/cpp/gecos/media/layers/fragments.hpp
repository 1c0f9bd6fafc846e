#pragma once

#include <memory>

#include "gecos/base/clock.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// Wraps a medium that loses packets, or carries only small ones: packets up to `largest_transfer`
/// go through it. Packets above the piece size of the medium's offer are sent in pieces
/// (transfer.hpp); lost pieces are sent again until the other end has all. Both ends must be
/// wrapped.
///
/// A link sends one large packet at a time; a second one fails with Full. A large packet that is
/// being sent, or that arrived last, is not sent again. receive() and beat() of both ends drive the
/// transfer.
std::unique_ptr<Medium> make_fragmented(std::unique_ptr<Medium> inner, const Clock& clock);

}  // namespace gecos::media
