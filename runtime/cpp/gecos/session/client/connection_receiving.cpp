// How a client's session waits, and how the leader handles the packets that arrive.
#include <algorithm>
#include <array>
#include <utility>

#include "gecos/media/parts/waiting.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {

namespace {

/// A client with at least this many open calls may rest (ClientConnection::rest).
constexpr std::size_t calls_of_a_flood = 32;
/// Duration of a rest (ClientConnection::rest): about as long as the client polled in vain before
/// the rest.
constexpr Duration rest_of_a_flood = std::chrono::microseconds(400);

}  // namespace

void ClientConnection::poll_once() {
  std::size_t taken = 0;
  if (leader_lock_.try_take()) {
    taken = read_all();
    if (loss_look_due_.load(std::memory_order_relaxed)) {
      loss_look_due_.store(false, std::memory_order_relaxed);
      look_for_loss();
    }
    leader_lock_.drop();
  } else if (!repeats_ && leader_lock_.borrow()) {
    // The server wakes the leader for each packet that can end the leader's wait. So this thread
    // need not wake it.
    taken = read_all();
    leader_lock_.release();
  }
  if (taken != 0) leader_lock_.notify(nullptr);
}

bool ClientConnection::wait(const void* subject, FunctionRef<bool()> done, TimePoint deadline) {
  if (done()) return true;
  for (;;) {
    if (leader_lock_.try_take()) {
      const bool finished = lead(done, deadline);
      leader_lock_.drop();
      // the maintenance thread continues to read packets for the watchers
      if (has_watchers()) wake_maintenance();
      return finished;
    }
    switch (leader_lock_.follow(subject, done, deadline)) {
      case LeaderLock::Woken::Done:
        return true;
      case LeaderLock::Woken::TimedOut:
        return done();
      case LeaderLock::Woken::Notified:
        break;
    }
  }
}

bool ClientConnection::lead(FunctionRef<bool()> done, TimePoint deadline) {
  bool rested = false;
  bool slept = false;
  spin_.begin();
  for (;;) {
    const std::size_t taken = read_all();
    if (slept && taken == 0) look_for_loss();
    const bool finished = done();
    if (std::exchange(slept, false)) {
      spin_.woke(connection_->peer_whereabouts().rang_at,
                 finished ? media::Woken::ByAnswer : media::Woken::Early);
      spin_.begin();
    }
    if (finished) return true;
    if (taken != 0) {
      leader_lock_.notify(nullptr);
      // The deadline is checked here too: replies to the calls of other threads may arrive without
      // end.
      if (deadline != TimePoint::max() && std::chrono::steady_clock::now() >= deadline)
        return false;
      rested = false;
      spin_.begin();
    } else if (!spin_.again([this] { return media::place_of(connection_->peer_whereabouts()); })) {
      if (std::chrono::steady_clock::now() >= deadline) return false;
      rested = !rested && rest(done, deadline);
      if (rested) {
        spin_.begin();
      } else {
        sleep(done, deadline);
        slept = true;
      }
      leader_lock_.notify(nullptr);
    }
  }
}

/// A client with many open calls that shares a core with its server leaves the core to the server
/// for a while. If each single reply woke this client, it would take the core from the server every
/// time, and all other clients would wait.
bool ClientConnection::rest(FunctionRef<bool()> done, TimePoint deadline) {
  if (!spin_.gave_way()) return false;
  if (calls_.open() < calls_of_a_flood) return false;
  quiet_leader();
  if (done()) return true;
  const std::array woken_by{leader_event_.descriptor()};
  media::sleep_on(woken_by, std::min(deadline, std::chrono::steady_clock::now() + rest_of_a_flood));
  return true;
}

void ClientConnection::sleep(FunctionRef<bool()> done, TimePoint deadline) {
  quiet_leader();
  if (connection_->prepare_to_sleep() && !done()) {
    descriptors_.assign(connection_->descriptors().begin(), connection_->descriptors().end());
    descriptors_.push_back(leader_event_.descriptor());
    leader_lock_.rest();
    media::sleep_on(descriptors_, deadline);
    leader_lock_.resume();
  }
  connection_->woke();
}

void ClientConnection::wake_leader() {
  leader_event_.notify();
  leader_called_.store(true);  // after notify(), or the event might never be drained
}

void ClientConnection::quiet_leader() {
  if (leader_called_.exchange(false)) leader_event_.drain();
}

std::size_t ClientConnection::read_all() {
  std::size_t taken = 0;
  while (const auto packet = connection_->receive()) {
    take_packet(*packet);
    ++taken;
  }
  return taken;
}

void ClientConnection::look_for_loss() {
  const media::Loss loss = connection_->loss();
  if (loss == media::Loss::None || lost()) return;
  read_all();  // reads the replies that the server sent before the loss
  const std::string who = welcome_.object + " (" + connection_->peer().description + ")";
  switch (loss) {
    case media::Loss::Died:
      return lose(Ending::Died, "the server of " + who + " died");
    case media::Loss::Broken:
      return lose(Ending::Broken, "the server of " + who + " broke the rules of its medium: " +
                                      connection_->loss_text());
    default:
      return lose(Ending::Closed, "the server closed the session with " + who);
  }
}

void ClientConnection::take_packet(ByteView bytes) {
  const auto packet = wire::decode_packet(bytes);
  if (!packet || packet->header.session != id_) return;
  if (packet->header.version != wire::packet_version) return;
  heard_.store(heard_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  switch (packet->header.kind) {
    case wire::PacketKind::Reply:
    case wire::PacketKind::Progress:
      if (packet->header.counter == 0) return;  // damaged or malicious: no call has counter 0
      return packet->header.kind == wire::PacketKind::Reply ? take_reply(*packet)
                                                            : take_progress(*packet);
    case wire::PacketKind::Goodbye:
      goodbye_heard_.store(true, std::memory_order_release);
      if (closed()) return lose(Ending::ByUs, closed_by_us);  // the answer to our Goodbye
      return lose(Ending::Closed,
                  "the server closed the session with " + welcome_.object + text_of(packet->body));
    default:
      return;  // packet kinds of a newer server, and late answers to a Hello
  }
}

void ClientConnection::take_reply(const wire::PacketView& packet) {
  const auto command = calls_.take_replied(packet.header.counter);
  if (!command) return;  // the reply arrived before; this is a copy
  // the call was a `stop`, which renewed the status of this client
  if (packet.header.epoch != Epoch{}) leases_.renewed(packet.header.epoch);
  const auto detail = detail_from(static_cast<std::uint8_t>(packet.header.flags));
  // Over a medium that loses nothing, OUTCOME_UNKNOWN means that the server has answered this call
  // and the reply was lost: the medium is broken.
  if (!repeats_ && detail == Detail::OutcomeUnknown) answer_lost_.store(true);
  if (detail == Detail::Done) {
    command->finish(packet.body);
  } else {
    command->fail(failure_from(detail, packet.body));
  }
  leader_lock_.notify(command.get());
}

void ClientConnection::take_progress(const wire::PacketView& packet) {
  const auto command = calls_.arrived(packet.header.counter);
  if (!command) return;
  const auto detail = detail_from(static_cast<std::uint8_t>(packet.header.flags));
  const auto body = wire::from_bytes<ProgressBody>(packet.body);
  if (!body || !detail || *detail < Detail::Queued || *detail > Detail::Canceling) return;
  command->report(*detail, *body);
}

}  // namespace gecos::session
