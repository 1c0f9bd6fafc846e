#pragma once

#include <memory>

#include "gecos/base/clock.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// Wraps a medium that loses packets or accepts only small packets, so that packets of up to
/// `largest_transfer` bytes can be sent. Packets that are larger than the piece size in the
/// medium's capabilities are split into pieces (transfer.hpp). Lost pieces are sent again until the
/// receiver has all pieces. The media of both ends must be wrapped.
///
/// A connection sends only one large packet at a time. Sending another large packet meanwhile fails
/// with Full. Sending the same large packet again during its transfer does not start a second
/// transfer. The transfer makes progress when receive() and beat() are called at both ends.
std::unique_ptr<Medium> make_fragmented(std::unique_ptr<Medium> inner, const Clock& clock);

}  // namespace gecos::media
