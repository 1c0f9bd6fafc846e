#pragma once

#include <optional>
#include <string>

#include "gecos/broker_types.hpp"

/// Decides which names the broker lists, so that a registration takes little memory, and no name
/// harms a terminal.
namespace gecos::broker {

/// Returns why the broker does not list `what`; an empty text if the broker lists `what`.
/// `admitted`: the users and hosts that the program of the server admits.
std::string why_not_listed(const Entry& what, const std::optional<AdmittedNames>& admitted);

}  // namespace gecos::broker
