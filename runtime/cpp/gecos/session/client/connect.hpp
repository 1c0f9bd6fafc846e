#pragma once

#include <memory>
#include <string>

#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

/// Connects to `address`, for example "shm:…", and opens a session with an object of the interface
/// `wanted`. Calls `prepare` with the session before any other code uses the session. On failure
/// stores the detailed state of the failure in `*why`.
tl::expected<std::shared_ptr<ClientConnection>, std::string> connect(
    Runtime& runtime, const std::string& address, const InterfaceDescription& wanted,
    TimePoint deadline, Detail* why = nullptr,
    FunctionRef<void(ClientConnection&)> prepare = [](ClientConnection&) {});

}  // namespace gecos::session
