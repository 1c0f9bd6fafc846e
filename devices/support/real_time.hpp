#pragma once

#include <optional>
#include <string>

namespace devices {

/// Gives the calling thread a real-time priority (SCHED_FIFO, 80 of 99) and keeps the memory of the
/// process in RAM, so that neither other programs nor page faults delay a control loop. Does as
/// much of this as the system permits. Returns a text that says what the system does not permit and
/// how to permit it; nullopt if it permits both.
///
/// A page is locked when it is first touched (MCL_ONFAULT). Otherwise, the whole stacks of all
/// threads would be locked in RAM, although the threads use only a small part of them.
std::optional<std::string> make_real_time();

}  // namespace devices
