#include "gecos/session/client/connect.hpp"

#include <system_error>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/client/open_session.hpp"

namespace gecos::session {

tl::expected<std::shared_ptr<ClientConnection>, std::string> connect(
    Runtime& runtime, const std::string& address, const InterfaceDescription& wanted,
    TimePoint deadline, Detail* why, FunctionRef<void(ClientConnection&)> prepare) {
  if (why != nullptr) *why = Detail::NoServer;
  const auto kind = media::kind_from(std::string_view(address).substr(0, address.find(':')));
  if (!kind) {
    return tl::unexpected("'" + address +
                          "' is not an address: an address begins with inproc:, shm: or lcm:");
  }
  const auto opened = runtime.medium(*kind);
  if (!opened) return tl::unexpected(opened.error().text);
  using Session = tl::expected<std::shared_ptr<ClientConnection>, NotOpened>;
  const auto open = [&]() -> Session {
    try {
      auto connection = (*opened)->connect(address);
      if (!connection) {
        return tl::unexpected(NotOpened{Detail::NoServer, connection.error().text});
      }
      return open_session(runtime.shared_from_this(), std::move(*connection), wanted, deadline)
          .map_error([&](NotOpened failed) {
            failed.reason = address + ": " + failed.reason;
            return failed;
          });
    } catch (const std::system_error& failed) {
      return tl::unexpected(NotOpened{Detail::NoServer, address + ": " + failed.what()});
    }
  };
  auto session = open();
  log_debug("media", session ? address + ": connected" : session.error().reason);
  if (!session) {
    if (why != nullptr) *why = session.error().detail;
    return tl::unexpected(session.error().reason);
  }
  (*session)->found_at(address);
  prepare(**session);
  runtime.maintenance().add(std::shared_ptr<TickTarget>(*session, &(*session)->tick_target()));
  runtime.close_at_exit(*session);
  return *session;
}

}  // namespace gecos::session
