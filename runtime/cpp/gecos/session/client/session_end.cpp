#include "gecos/session/client/session_end.hpp"

#include <algorithm>

#include "gecos/base/log.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/retry.hpp"

namespace gecos::session {
namespace {

constexpr const char* closed_by_us = "this program closed the session";

}  // namespace

SessionEnd::SessionEnd(media::Connection& connection, const Welcome& welcome, CallSender& calls,
                       PacketReceiver& receiver, ConnectionReader& reader,
                       SessionFailover& failover)
    : connection_(connection),
      welcome_(welcome),
      calls_(calls),
      receiver_(receiver),
      reader_(reader),
      failover_(failover),
      reliable_(connection.capabilities().reliable) {}

void SessionEnd::close(Duration patience) {
  closed_.store(true, std::memory_order_relaxed);
  if (calls_.lost()) return;
  const TimePoint give_up = deadline_after(patience);
  if (!reliable_ && patience > Duration{}) {
    reader_.wait(
        nullptr, [this] { return calls_.lost() || calls_.everything_arrived(); }, give_up);
  }
  awaits_goodbye_.store(patience > Duration{}, std::memory_order_relaxed);
  bool sent = false;
  int tries = 1;
  do {
    if (!sent || !reliable_) sent = calls_.say_goodbye();
    if (patience == Duration{}) break;
    const TimePoint next = sent && reliable_ ? give_up : deadline_after(retry_after(tries++));
    reader_.wait(
        nullptr, [this] { return receiver_.goodbye_heard() || calls_.lost(); },
        std::min(next, give_up));
  } while (!calls_.lost() && std::chrono::steady_clock::now() < give_up);
  lose(Ending::ByUs, closed_by_us);
}

void SessionEnd::lose(Ending how, const std::string& text) {
  // The calls that wait at the server still run if the server has acknowledged the goodbye. They
  // also run if this program does not wait for the acknowledgement: in that case a proxy was
  // destroyed, and its commands are meant to continue.
  const bool drains = how == Ending::ByUs && (receiver_.goodbye_heard() ||
                                              !awaits_goodbye_.load(std::memory_order_relaxed));
  auto remains =
      calls_.end(how, text, drains ? CallSender::Queued::Run : CallSender::Queued::Withdrawn);
  if (!remains) return;
  log_info("client", "the session with " + welcome_.object + " ended: " + text);
  for (const auto& [counter, command] : remains->others) {
    // The failure of the command is not logged, because the program closed the session on purpose.
    if (drains) command->observe();
    command->fail(calls_.failure_of(*command, how, text));
  }
  reader_.wake_all();
  failover_.take_over(std::move(remains->repeatable));
}

void SessionEnd::on_goodbye(std::int8_t flags, ByteView body) {
  if (closed()) return lose(Ending::ByUs, closed_by_us);  // the answer to our Goodbye
  lose(flags == revokes ? Ending::Revoked : Ending::Closed,
       "the server closed the session with " + welcome_.object + text_of(body));
}

void SessionEnd::on_loss(media::Loss loss) {
  const std::string who = welcome_.object + " (" + connection_.peer().description + ")";
  switch (loss) {
    case media::Loss::Died:
      return lose(Ending::Died, "the server of " + who + " died");
    case media::Loss::Broken:
      return lose(Ending::Broken,
                  "the server of " + who +
                      " violated the protocol of its medium: " + connection_.loss_text());
    default:
      return lose(Ending::Closed, "the server closed the session with " + who);
  }
}

}  // namespace gecos::session
