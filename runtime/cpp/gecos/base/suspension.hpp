#pragma once

#include "gecos/base/clock.hpp"

namespace gecos {

/// The total time for which this machine was suspended since its start, as last noted by this
/// process; coarse clocks do not count that time. One load; thread-safe.
Duration noted_suspension();
/// Measures and stores the total time of suspension again. The maintenance thread calls this at
/// each tick.
void note_suspension(const Clock& clock);

}  // namespace gecos
