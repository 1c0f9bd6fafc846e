#include "gecos/session/client/packet_receiver.hpp"

#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {

std::shared_ptr<PendingCommand> PacketReceiver::take(ByteView bytes) {
  const auto packet = wire::decode_packet(bytes);
  if (!packet || packet->header.session != id_) return nullptr;
  if (packet->header.version != wire::packet_version) return nullptr;
  heard_.store(heard_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  switch (packet->header.kind) {
    case wire::PacketKind::Reply:
    case wire::PacketKind::Progress:
      // No call has the counter 0, so the packet is damaged or malicious.
      if (packet->header.counter == 0) return nullptr;
      if (packet->header.kind == wire::PacketKind::Reply) return take_reply(*packet);
      take_progress(*packet);
      return nullptr;
    case wire::PacketKind::Goodbye:
      goodbye_heard_.store(true, std::memory_order_release);
      end_.on_goodbye(packet->header.flags, packet->body);
      return nullptr;
    default:
      return nullptr;  // ignores packet kinds of a newer server, and late replies to a Hello
  }
}

std::shared_ptr<PendingCommand> PacketReceiver::take_reply(const wire::PacketView& packet) {
  auto command = calls_.take_replied(packet.header.counter);
  if (!command) return nullptr;  // the reply arrived before; this is a copy
  // The server adds an epoch to a reply when this client keeps its status under a newer epoch.
  if (packet.header.epoch != Epoch{}) leases_.renewed(packet.header.epoch);
  const auto detail = detail_from(static_cast<std::uint8_t>(packet.header.flags));
  // Over a medium that loses no packets, OUTCOME_UNKNOWN means that the server has answered this
  // call before and that its reply was lost. So the medium is broken.
  if (reliable_ && detail == Detail::OutcomeUnknown) answer_lost_.store(true);
  if (detail == Detail::Done) {
    command->finish(packet.body);
  } else {
    if (command->chain.failures) {
      command->chain.because_of = packet.header.acknowledged;
      // Only the command that failed causes a warning. The later commands that the server did not
      // carry out because of this failure cause none.
      if (command->chain.because_of != 0) command->observe();
    } else if (detail == Detail::NotStarted) {
      // The server may not know the operation of a call that it did not start. Therefore the
      // failure of this call does not keep later commands from being carried out.
      calls_.failures()->knows({true, packet.header.counter}, ChainReport::Known::Failure);
    }
    command->fail(failure_from(detail, packet.body));
  }
  return command;
}

void PacketReceiver::take_progress(const wire::PacketView& packet) {
  const auto command = calls_.arrived(packet.header.counter);
  if (!command) return;
  const auto detail = detail_from(static_cast<std::uint8_t>(packet.header.flags));
  const auto body = wire::from_bytes<ProgressBody>(packet.body);
  if (!body || !detail || *detail < Detail::Queued || *detail > Detail::Canceling) return;
  command->report(*detail, *body);
}

}  // namespace gecos::session
