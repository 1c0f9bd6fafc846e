#pragma once

#include <memory>

#include "gecos/media/medium.hpp"

namespace gecos::media {

/// Within this process: the rings of shm in private memory, woken by eventfds. The reference of how
/// a medium behaves. All media made by this meet each other; links that a fork inherits are dead.
std::unique_ptr<Medium> make_inproc();

}  // namespace gecos::media
