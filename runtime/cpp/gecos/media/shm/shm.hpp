#pragma once

#include <memory>
#include <string>

#include "gecos/media/medium.hpp"
#include "gecos/media/parts/bulk.hpp"
#include "gecos/media/shm/directory.hpp"

/// Shared memory between processes of one host.
///
/// A client connects to the server's Unix socket; the kernel names both users. Each side makes its
/// own sealed memory, which the other one maps read-only; calls go through rings in it, without the
/// kernel. A thread sleeps on descriptors: its eventfd, the socket, the peer's death.
///
/// The peer is not trusted with our memory, our time or our descriptors. Only a peer of the same
/// user (who could kill us anyway) is given an eventfd or notified through its own, since a hostile
/// holder of an eventfd can block a writer; others are woken through the socket, a microsecond
/// slower.
namespace gecos::media {

struct ShmOptions {
  std::string directory = shm::default_runtime_directory();
  /// Also meet processes of other users (and see to it above who may do what). Otherwise only the
  /// own user and root are met.
  bool other_users = false;
};

inline constexpr Offer shm_offer{.name = "shm",
                                 .reach = Reach::Host,
                                 .ordered = true,
                                 .reliable = true,
                                 .real_time = true,
                                 .reports_death = true,
                                 .authenticated = true,
                                 .shared_words = true,
                                 .largest_packet = largest_bulk_packet};

std::unique_ptr<Medium> make_shm(ShmOptions options = {});

}  // namespace gecos::media
