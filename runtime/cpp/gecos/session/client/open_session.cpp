#include "gecos/session/client/open_session.hpp"

#include <algorithm>

#include "gecos/base/log.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/retry.hpp"

namespace gecos::session {
namespace {

/// Returns why no Welcome arrived: the server refused the client, the connection was lost, or the
/// server did not answer.
NotOpened unanswered(media::Connection& connection) {
  const std::string& who = connection.peer().description;
  const media::Loss loss = connection.loss();
  const std::string why = connection.loss_text();
  if (loss == media::Loss::Refused) return {Detail::Refused, why};
  if (loss != media::Loss::None)
    return {Detail::NoServer, who + " did not accept the connection: " + why};
  return {Detail::NoServer, who + " did not answer" + (why.empty() ? "" : ": " + why)};
}

/// Returns the operations that client and server both have but define differently. Logs a warning
/// with their names.
std::vector<FunctionCode> differing_operations(const InterfaceDescription& wanted,
                                               const Welcome& welcome) {
  std::vector<FunctionCode> differing;
  std::string names;
  for (const auto& theirs : welcome.operations) {
    const auto differs = [&](const auto* ours) {
      if (ours == nullptr || ours->hash == theirs.hash) return;
      differing.push_back(theirs.code);
      names += (names.empty() ? "" : ", ") + std::string(ours->name);
    };
    differs(wanted.find(theirs.code));
    if (const auto* ours = wanted.find_stream(theirs.code); ours != nullptr && ours->event) {
      differs(ours);
    }
    differs(wanted.find_inward_stream(theirs.code));
  }
  std::ranges::sort(differing);
  if (!differing.empty()) {
    log_warning("session", welcome.object + ": the server's " + welcome.interface_name +
                               " differs from this program's " + std::string(wanted.name) +
                               " in the operations " + names +
                               "; this program refuses calls of them");
  }
  return differing;
}

/// Returns the next packet that arrives before `deadline`; nullopt when none arrived or the
/// connection is lost.
std::optional<wire::PacketView> next_packet(media::Connection& connection, TimePoint deadline) {
  for (;;) {
    while (const auto bytes = connection.receive()) {
      if (const auto packet = wire::decode_packet(*bytes)) return *packet;
    }
    if (connection.loss() != media::Loss::None || std::chrono::steady_clock::now() >= deadline) {
      return std::nullopt;
    }
    if (connection.prepare_to_sleep()) media::sleep_on(connection.descriptors(), deadline);
    connection.woke();
  }
}

}  // namespace

tl::expected<std::shared_ptr<ClientConnection>, NotOpened> open_session(
    std::shared_ptr<Runtime> runtime, std::unique_ptr<media::Connection> connection,
    const InterfaceDescription& wanted, TimePoint deadline) {
  wire::PacketHeader header;
  header.kind = wire::PacketKind::Hello;
  Bytes greeting;
  write_packet(greeting, header, wire::to_bytes(runtime->introduce(wanted)));

  for (int sent = 1;; ++sent) {
    if (const auto left = connection->send(greeting, {}); !left) {
      if (left.error() != media::SendProblem::Full) return tl::unexpected(unanswered(*connection));
    }
    const TimePoint again = connection->capabilities().reliable
                                ? deadline
                                : std::min(deadline, deadline_after(retry_after(sent)));
    while (const auto packet = next_packet(*connection, again)) {
      if (packet->header.kind == wire::PacketKind::Refused) {
        const auto detail = detail_from(static_cast<std::uint8_t>(packet->header.flags));
        return tl::unexpected(NotOpened{Detail::Refused, failure_from(detail, packet->body).text});
      }
      if (packet->header.kind != wire::PacketKind::Welcome ||
          packet->header.version != wire::packet_version) {
        continue;
      }
      auto welcome = wire::from_bytes<Welcome>(packet->body);
      if (!welcome || packet->header.session == SessionId{} || welcome->credits == 0) {
        return tl::unexpected(NotOpened{Detail::Refused, "the server's welcome does not decode"});
      }
      auto differing = differing_operations(wanted, *welcome);
      return std::make_shared<ClientConnection>(std::move(runtime), std::move(connection),
                                                packet->header.session, std::move(*welcome),
                                                std::move(differing));
    }
    const bool lost = connection->loss() != media::Loss::None;
    if (lost || std::chrono::steady_clock::now() >= deadline) {
      return tl::unexpected(unanswered(*connection));
    }
  }
}

}  // namespace gecos::session
