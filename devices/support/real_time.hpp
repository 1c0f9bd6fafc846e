#pragma once

#include <optional>
#include <string>

namespace devices {

/// Gives the calling thread a real-time priority (SCHED_FIFO, 80 of 99) and keeps the memory of the
/// process in RAM, so that neither other programs nor page faults delay a control loop. Does as
/// much of this as the system permits. Returns a text that says what the system does not permit and
/// how to permit it; nullopt if it permits both.
///
/// A page is locked when it is first touched (MCL_ONFAULT): the stacks of all threads together are
/// much larger than what the threads use of them.
std::optional<std::string> make_real_time();

}  // namespace devices
