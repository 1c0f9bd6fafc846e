#pragma once

#include <chrono>
#include <thread>

namespace stress {

/// What a client does before it asks again for a server that is away. Nobody tells it when one
/// comes, and who asked without pause would take the machine from the server that starts.
inline void rest_before_another_try() { std::this_thread::sleep_for(std::chrono::milliseconds(5)); }

}  // namespace stress
