#pragma once

#include <memory>
#include <string>

#include "gecos/media/medium.hpp"
#include "gecos/media/parts/bulk.hpp"
#include "gecos/media/shm/directory.hpp"

/// Shared memory between processes of one host.
///
/// A client connects to the server's Unix socket; the kernel tells each side the user of the other.
/// Each side makes its own sealed memory, which the other side maps read-only; packets go through
/// rings in this memory, without the kernel. A thread sleeps on descriptors: its eventfd, the
/// socket, the peer's pidfd.
///
/// The peer is not trusted with our memory, our time or our descriptors. Only a peer of the same
/// user (who could kill this process anyway) is notified through its eventfd, because a hostile
/// holder of an eventfd can block a writer; other peers are notified through the socket, a
/// microsecond slower.
namespace gecos::media {

struct ShmOptions {
  std::string directory = shm::default_runtime_directory();
  /// Whether programs of other users may connect; then the layers above must check permissions.
  /// Otherwise only programs of this user and of root connect.
  bool other_users = false;
};

inline constexpr Capabilities shm_capabilities{.name = "shm",
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
