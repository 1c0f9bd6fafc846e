#include "gecos/session/client/broker_client.hpp"

#include <algorithm>
#include <cstdio>

#include "gecos/base/seconds.hpp"
#include "gecos/broker_calls.hpp"      // generated from idl/gecos/broker.gidl
#include "gecos/broker_interface.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/own_call.hpp"

namespace gecos::session {
namespace {

/// Returns advice for a program that asked for a name that the broker does not know. `names` are
/// the names that the broker knows.
std::string advice(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  if (text.empty()) return "start the object's server: the broker knows no object";
  return "start the object's server, or choose a name that the broker knows: " + text;
}

/// Converts a duration that a broker sent. Returns at most one minute, because a longer duration is
/// not plausible.
Duration longest_provisional(double seconds) { return from_seconds(std::min(seconds, 60.0)); }

/// Waits for the broker's answer to the call `asked`.
template <class Reply, class T>
tl::expected<T, std::string> answer(CommandCore& asked, TimePoint deadline) {
  if (!asked.wait_until(deadline))
    return tl::unexpected(std::string("the broker did not answer in time"));
  if (asked.progress().detail != Detail::Done)
    return tl::unexpected("the broker did not answer: " + asked.failure().text);
  T value;
  wire::Decoder from(asked.result());
  if (read_result<Reply>(from, value)) return value;
  return tl::unexpected("the broker's answer does not decode: " + from.error().message());
}

/// Returns true when `asked` failed because the broker is of an older version and does not have the
/// operation.
bool is_older(const CommandCore& asked) {
  return asked.progress().detail == Detail::UnknownOperation;
}

/// Returns why no proxy can be created for `object`, and what to do.
std::string silence_of(const SilentObject& object) {
  char seconds[32];
  std::snprintf(seconds, sizeof seconds, "%.1f s", object.silent_for);
  const Entry& entry = object.entry;
  const std::string pid = std::to_string(entry.pid);
  return "the server of " + entry.name + " (" + entry.user + "@" + entry.hostname + ", pid " + pid +
         ") has been silent for " + seconds + ": resume it if it is suspended (kill -CONT " + pid +
         "), end it and start it again if it hangs, or look at its host and the network";
}

}  // namespace

tl::expected<Entry, std::string> look_up(Context& lab, const std::string& name,
                                         TimePoint deadline) {
  const auto broker = lab.broker(deadline);
  if (!broker) return tl::unexpected(broker.error().text);
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
    if (const auto silent = look_up_silent(lab, name, deadline)) {
      return tl::unexpected(silence_of(*silent));
    }
    return tl::unexpected("no object is called " + name + "; " + advice(unknown->known));
  }
  return tl::unexpected("the broker did not answer: " + failure.text);
}

std::optional<SilentObject> look_up_silent(Context& lab, const std::string& name,
                                           TimePoint deadline) {
  const auto broker = lab.broker(deadline);
  if (!broker) return std::nullopt;
  auto found = answer<Broker_silent_result, std::vector<SilentObject>>(
      *own_call(**broker, BrokerInterface::silent), deadline);
  if (!found) return std::nullopt;
  const auto one =
      std::ranges::find(*found, name, [](const auto& each) { return each.entry.name; });
  return one == found->end() ? std::nullopt : std::optional(std::move(*one));
}

tl::expected<std::vector<Entry>, std::string> query(Context& lab, const std::string& interface_name,
                                                    TimePoint deadline) {
  const auto broker = lab.broker(deadline);
  if (!broker) return tl::unexpected(broker.error().text);
  if (!interface_name.empty()) {
    const auto asked =
        own_call(**broker, BrokerInterface::query, Broker_query_arguments{interface_name});
    auto found = answer<Broker_query_result, std::vector<Entry>>(*asked, deadline);
    if (found || !is_older(*asked)) return found;
  }
  auto found = answer<Broker_list_result, std::vector<Entry>>(
      *own_call(**broker, BrokerInterface::list), deadline);
  if (found && !interface_name.empty()) {
    std::erase_if(*found, [&](const Entry& one) {
      return one.interface_name != interface_name &&
             std::ranges::find(one.bases, interface_name) == one.bases.end();
    });
  }
  return found;
}

tl::expected<ListChanges, std::string> list_changes(Context& lab, const ListRevision& since,
                                                    TimePoint deadline) {
  const auto broker = lab.broker(deadline);
  if (!broker) return tl::unexpected(broker.error().text);
  const auto asked = own_call(**broker, BrokerInterface::changes, Broker_changes_arguments{since});
  auto found = answer<Broker_changes_result, ListChanges>(*asked, deadline);
  if (found || !is_older(*asked)) return found;
  auto listed = answer<Broker_list_result, std::vector<Entry>>(
      *own_call(**broker, BrokerInterface::list), deadline);
  if (!listed) return tl::unexpected(std::move(listed.error()));
  ListChanges changes;
  changes.revision.life = (*broker)->welcome().incarnation;
  changes.whole = true;
  for (Entry& entry : *listed)
    changes.changed.push_back({std::move(entry), Presence::ONLINE, 0, 0});
  return changes;
}

std::optional<Duration> running_for(ClientConnection& broker, TimePoint deadline) {
  const auto found = answer<Broker_changes_result, ListChanges>(
      *own_call(broker, BrokerInterface::changes, Broker_changes_arguments{}), deadline);
  if (!found) return std::nullopt;
  return from_seconds(found->running_for);
}

std::shared_ptr<CommandCore> register_object(ClientConnection& broker, const Entry& entry,
                                             Duration served_for,
                                             const std::optional<AdmittedNames>& admitted,
                                             std::optional<Duration> confirmed_ago) {
  Broker_enlist_arguments arguments{entry, to_seconds(served_for), admitted, std::nullopt};
  if (confirmed_ago) arguments.confirmed_ago = to_seconds(*confirmed_ago);
  return own_call(broker, BrokerInterface::enlist, arguments);
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
