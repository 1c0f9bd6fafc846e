#pragma once

#include <memory>

#include "gecos/base/clock.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// Wraps a medium that loses packets or accepts only small ones, so that packets up to
/// `largest_transfer` bytes can be sent. Packets above the piece size of the medium's capabilities
/// are split into pieces (transfer.hpp); lost pieces are sent again until the other end has all
/// pieces. Both ends must be wrapped.
///
/// A connection sends one large packet at a time; sending another one meanwhile fails with Full.
/// Sending the same large packet again while it is under way does not start another transfer.
/// receive() and beat() of both ends drive the transfer.
std::unique_ptr<Medium> make_fragmented(std::unique_ptr<Medium> inner, const Clock& clock);

}  // namespace gecos::media
