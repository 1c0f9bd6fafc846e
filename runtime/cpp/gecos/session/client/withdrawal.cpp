#include "gecos/session/client/withdrawal.hpp"

#include "gecos/session/protocol/start_words.hpp"

namespace gecos::session {

bool Withdrawal::write(std::uint64_t last) {
  if (!connection_.capabilities().shared_words) return false;
  connection_.write_word(withdrawn_word, last);
  written_ = true;
  return true;
}

Failure Withdrawal::failure_of(const PendingCommand& command, Ending how,
                               const std::string& text) const {
  if (!connection_.capabilities().reliable && !command.retry.on_its_way) {
    return {Detail::NotStarted, text + "; this command was never sent", {}, {}};
  }
  if (!may_have_started(command, how)) {
    return {Detail::NotStarted, text + "; the server had not started this command", {}, {}};
  }
  if (how == Ending::Died) {
    return {Detail::ServerCrashed,
            text +
                "; the command may have been carried out in part: check the "
                "object before you send it again",
            {},
            {}};
  }
  return {
      Detail::OutcomeUnknown, text + "; whether the command was carried out is not known", {}, {}};
}

/// Returns false only when it is certain that the server has not started the call and never will.
bool Withdrawal::may_have_started(const PendingCommand& command, Ending how) const {
  if (how == Ending::Broken) return true;  // the shared words of a broken server prove nothing
  if (written_ && command.marked_words != 0) {
    for (std::size_t word = 0; word < media::shared_word_count; ++word) {
      const bool may_stand_here = (command.marked_words >> word & 1U) != 0;
      if (may_stand_here && connection_.peer_word(word) >= command.counter) return true;
    }
    return false;
  }
  // A server that is gone reads no more packets. A server that is only silent may still read them.
  if (how != Ending::Died && !closed_by_server(how)) return true;
  const auto taken = connection_.taken_by_peer();
  return !taken || command.sent_as <= *taken;
}

}  // namespace gecos::session
