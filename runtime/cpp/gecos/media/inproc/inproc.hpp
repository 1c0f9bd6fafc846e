#pragma once

#include <memory>

#include "gecos/media/buffers/bulk.hpp"
#include "gecos/media/medium.hpp"

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

/// Makes a medium that connects threads of this process. It uses the rings of the medium shm, but
/// in private memory, and eventfds for wake-ups. It is the reference implementation of a medium. A
/// client of one medium that this function has made can connect to an acceptor of another one in
/// the same process. A forked child cannot use the connections of its parent.
std::unique_ptr<Medium> make_inproc();

}  // namespace gecos::media
