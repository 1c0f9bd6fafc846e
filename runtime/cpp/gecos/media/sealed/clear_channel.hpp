#pragma once

#include <memory>
#include <string>

#include "gecos/media/sealed/network.hpp"

namespace gecos::media {

/// Opens a channel for messages that are not sealed, on `options.open_port`. Returns null when the
/// network has no such port, and an error when the port cannot be opened or the name is too long.
tl::expected<std::unique_ptr<OpenChannel>, MediumError> open_clear_channel(
    const SealedOptions& options, const std::string& name);

}  // namespace gecos::media
