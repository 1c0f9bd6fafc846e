#pragma once

#include <functional>
#include <string>
#include <thread>

namespace gecos {

/// Starts a thread that calls `run`. The thread has the first 15 characters of `name` as its name,
/// which debuggers show. The thread blocks all signals, so that the program's own threads get the
/// signals. Throws std::system_error when no thread can be started.
std::thread start_thread(const std::string& name, std::function<void()> run);

}  // namespace gecos
