#pragma once

#include <chrono>
#include <thread>

namespace stress {

/// A client's pause before it looks again for a missing server. No event announces a new server,
/// and a client that retries without pause would take CPU time from the server that starts.
inline void rest_before_another_try() { std::this_thread::sleep_for(std::chrono::milliseconds(5)); }

}  // namespace stress
