#include "packet_target.hpp"

#include "targets.hpp"

namespace gecos::fuzz {

void try_packets(ByteView input) {
  Script script(input);
  if (script.one_in(2)) return try_connected(script);
  try_served(script);
}

}  // namespace gecos::fuzz
