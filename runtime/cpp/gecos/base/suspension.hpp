#pragma once

#include "gecos/base/clock.hpp"

namespace gecos {

/// How long this machine has been suspended since it was started, as this process saw it last: what
/// coarse and cheap clocks leave out. One load; any thread.
Duration noted_suspension();
/// Looks again. Maintenance does so at each tick.
void note_suspension(const Clock& clock);

}  // namespace gecos
