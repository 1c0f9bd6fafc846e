// A medium that only tests know, small on purpose: 200-byte datagrams over socketpairs within this
// process. Once as it is, and once as a network that others can hear, of which
// gecos/media/sealed makes a medium.
#pragma once

#include <memory>
#include <string>

#include "gecos/media/medium.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/network.hpp"

namespace gecos::media {

inline constexpr std::size_t pair_datagram = 200;

inline constexpr Capabilities pair_capabilities{.name = "pair",
                                                .reach = Reach::Process,
                                                .reliable = false,
                                                .real_time = false,
                                                .reports_death = false,
                                                .largest_packet = pair_datagram};

inline constexpr Capabilities sealed_pair_capabilities{
    .name = "pair",
    .reach = Reach::Process,
    .ordered = false,
    .reliable = false,
    .real_time = false,
    .reports_death = false,
    .overheard = true,
    .connectionless = true,
    .largest_packet = pair_datagram - packet_overhead};

std::unique_ptr<Medium> make_pair_medium();

/// Its datagrams reach everybody who opens the port.
std::shared_ptr<const DatagramNetwork> make_pair_network();

std::unique_ptr<Medium> make_sealed_pair(const std::string& key_directory);

}  // namespace gecos::media
