#pragma once

#include <string>
#include <vector>

#include "gecos/base/clock.hpp"

namespace gecos::broker {

/// The places at which programs of this host may look for a broker and reach one of another
/// process. Waits at most `patience` at each.
std::vector<std::string> other_brokers(Duration patience);

/// Looks for them, and tells the user that names are unique at each of them only.
void warn_of_other_brokers();

}  // namespace gecos::broker
