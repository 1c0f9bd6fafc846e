#pragma once

#include <memory>
#include <string>

#include "gecos/session/client/client_connection.hpp"

namespace gecos::session {

/// The reason why no session was opened.
struct NotOpened {
  Detail detail = Detail::NoServer;
  std::string reason;
};

/// Opens a session with the server at the other end of `connection`: sends a Hello and waits for
/// the server's answer until `deadline`. If the medium may lose packets, sends the Hello again
/// until the answer arrives.
tl::expected<std::shared_ptr<ClientConnection>, NotOpened> open_session(
    std::shared_ptr<Runtime> runtime, std::unique_ptr<media::Connection> connection,
    const InterfaceDescription& wanted, TimePoint deadline);

}  // namespace gecos::session
