#pragma once

#include <memory>
#include <string>

#include "gecos/media/buffers/bulk.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/media/shm/directory.hpp"

/// The medium shm: shared memory between processes of one host.
///
/// A client connects to the Unix socket of a server. The kernel tells each side the user of the
/// other side. Each side makes sealed memory, which the other side can map only for reading.
/// Packets go through rings in this memory, without the kernel. A thread that sleeps waits on three
/// descriptors: its eventfd, the socket, and the pidfd of the peer.
///
/// The peer is not trusted: it cannot write our memory, delay our threads or use up our
/// descriptors. A hostile process can block every process that writes to its eventfd. Therefore
/// only a peer of the same user is notified through its eventfd, because this user could also kill
/// this process. Other peers are notified through the socket, which takes a microsecond longer.
namespace gecos::media {

struct ShmOptions {
  std::string directory = shm::default_runtime_directory();
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
