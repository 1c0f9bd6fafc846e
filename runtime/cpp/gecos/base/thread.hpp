#pragma once

#include <functional>
#include <string>
#include <thread>

namespace gecos {

/// A thread of ours: named for debuggers (at most 15 characters), and no signal is delivered to it,
/// so that the program's own threads get them. Throws std::system_error when none can be had.
std::thread start_thread(const std::string& name, std::function<void()> run);

}  // namespace gecos
