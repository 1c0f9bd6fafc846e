#include "gecos/session/client/broker_client.hpp"

#include <algorithm>

#include "gecos/broker_calls.hpp"      // generated from idl/gecos/broker.gidl
#include "gecos/broker_interface.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/own_call.hpp"

namespace gecos::session {
namespace {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "the broker knows no object" : "the broker knows " + text;
}

/// Converts a duration that a broker sent. Returns at most one minute, because a longer duration is
/// not plausible.
Duration longest_provisional(double seconds) {
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(seconds > 0 ? std::min(seconds, 60.0) : 0.0));
}

}  // namespace

tl::expected<Entry, std::string> look_up(Context& lab, const std::string& name,
                                         TimePoint deadline) {
  const auto broker = lab.broker(deadline);
  if (!broker) return tl::unexpected(broker.error());
  const auto command = own_call(**broker, BrokerInterface::lookup, Broker_lookup_arguments{name});
  if (!command->wait_until(deadline))
    return tl::unexpected(std::string("the broker did not answer in time"));
  if (command->progress().detail == Detail::Done) {
    Entry entry;
    wire::Decoder from(command->result());
    if (read_result<Broker_lookup_result>(from, entry)) return entry;
    return tl::unexpected("the broker's answer does not decode: " + from.error().message());
  }
  const Failure& failure = command->failure();
  if (const auto unknown = failure.as<UnknownName>()) {
    return tl::unexpected("no object is called " + name + "; " + listed(unknown->known));
  }
  return tl::unexpected("the broker did not answer: " + failure.text);
}

std::shared_ptr<CommandCore> register_object(ClientConnection& broker, const Entry& entry,
                                             Duration served_for) {
  const double seconds = std::chrono::duration<double>(served_for).count();
  return own_call(broker, BrokerInterface::enlist, Broker_enlist_arguments{entry, seconds});
}

tl::expected<Duration, NotRegistered> await_registered(CommandCore& asked, TimePoint deadline) {
  if (!asked.wait_until(deadline)) {
    return tl::unexpected(NotRegistered{false, {}, false, "the broker did not answer in time"});
  }
  if (asked.progress().detail == Detail::Done) {
    const auto reply = layout::from_bytes<Broker_enlist_result>(asked.result());
    if (!reply || !reply->settles_in)
      return Duration::zero();  // an older broker does not send this: its registrations are final
    return longest_provisional(*reply->settles_in);
  }
  const Failure& failure = asked.failure();
  if (const auto taken = failure.as<NameTaken>()) {
    return tl::unexpected(
        NotRegistered{true, taken->by, false,
                      "the name " + taken->name + " is taken by " + taken->by +
                          "; end that server, or serve this object under another name"});
  }
  return tl::unexpected(NotRegistered{false,
                                      {},
                                      failure.state() == State::ConnectionFailed ||
                                          // the broker is shutting down
                                          failure.detail == Detail::Stopped,
                                      "the broker did not register the object: " + failure.text});
}

void unregister_object(ClientConnection& broker, const std::string& name) {
  const auto command = own_call(broker, BrokerInterface::withdraw, Broker_withdraw_arguments{name});
  command->wait_until(deadline_after(std::chrono::milliseconds(500)));
}

}  // namespace gecos::session
