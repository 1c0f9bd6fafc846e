#pragma once

#include <string>
#include <vector>

#include "gecos/base/clock.hpp"

namespace gecos::broker {

/// Returns the addresses at which programs of this host would find the broker of another process.
/// Waits at most `patience` at each address.
std::vector<std::string> other_brokers(Duration patience);

/// Searches for other brokers and logs a warning for each, because object names are unique only
/// within one broker.
void warn_of_other_brokers();

}  // namespace gecos::broker
