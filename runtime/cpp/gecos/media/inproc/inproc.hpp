#pragma once

#include <memory>

#include "gecos/media/medium.hpp"
#include "gecos/media/parts/bulk.hpp"

namespace gecos::media {

inline constexpr Capabilities inproc_capabilities{
    .name = "inproc",
    .reach = Reach::Process,
    .ordered = true,
    .reliable = true,
    .real_time = true,
    .reports_death = false,  // the peer dies with this process
    .authenticated = true,
    .shared_words = true,
    .largest_packet = largest_bulk_packet};

/// A medium within this process: the rings of shm in private memory, with eventfds for wake-ups.
/// The reference implementation of a medium. All media that this function makes reach each other.
/// Connections that a forked child inherits are dead.
std::unique_ptr<Medium> make_inproc();

}  // namespace gecos::media
