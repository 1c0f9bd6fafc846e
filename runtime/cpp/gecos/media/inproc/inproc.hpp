#pragma once

#include <memory>

#include "gecos/media/medium.hpp"
#include "gecos/media/parts/bulk.hpp"

namespace gecos::media {

inline constexpr Offer inproc_offer{.name = "inproc",
                                    .reach = Reach::Process,
                                    .ordered = true,
                                    .reliable = true,
                                    .real_time = true,
                                    .reports_death = false,  // who dies here dies with us
                                    .authenticated = true,
                                    .shared_words = true,
                                    .largest_packet = largest_bulk_packet};

/// Within this process: the rings of shm in private memory, woken by eventfds. The reference of how
/// a medium behaves. All media made by this meet each other; links that a fork inherits are dead.
std::unique_ptr<Medium> make_inproc();

}  // namespace gecos::media
