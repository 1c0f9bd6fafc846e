#pragma once

#include <functional>
#include <string>
#include <thread>

namespace gecos {

/// Starts a thread that has a name for debuggers (at most 15 characters) and blocks all signals, so
/// that the program's own threads get them. Throws std::system_error when no thread can be started.
std::thread start_thread(const std::string& name, std::function<void()> run);

}  // namespace gecos
