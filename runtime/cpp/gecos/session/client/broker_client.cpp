#include "gecos/session/client/broker_client.hpp"

#include <algorithm>
#include <optional>

#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/protocol/builtin_codec.hpp"
#include "gecos/session/protocol/function_code.hpp"

namespace gecos::session {
namespace {

OperationDescription broker_operation(std::string_view name) {
  OperationDescription operation;
  operation.code = function_code("gecos::Broker::" + std::string(name));
  operation.name = name;
  operation.status = access::Status::Sensor;
  return operation;
}

std::shared_ptr<CommandCore> call_with_text(ClientConnection& broker, std::string_view operation,
                                            const std::string& text) {
  return broker.call(broker_operation(operation), wire::string_size(text),
                     [&](wire::Encoder& to) { to.put_string(text); }, {});
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "nothing is registered" : "known are " + text;
}

/// Of what a broker says; more than a minute is nonsense.
Duration longest_provisional(double seconds) {
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(seconds > 0 ? std::min(seconds, 60.0) : 0.0));
}

}  // namespace

const InterfaceDescription& broker_interface() {
  static const InterfaceDescription description = [] {
    InterfaceDescription broker;
    broker.name = "gecos::Broker";
    return broker;
  }();
  return description;
}

tl::expected<Entry, std::string> look_up(Context& lab, const std::string& name,
                                         TimePoint deadline) {
  const auto broker = lab.broker(deadline);
  if (!broker) return tl::unexpected(broker.error());
  const auto command = call_with_text(**broker, "lookup", name);
  if (!command->wait_until(deadline))
    return tl::unexpected(std::string("the broker did not answer in time"));
  if (command->progress().detail == Detail::Done) {
    Entry entry;
    wire::Decoder from(command->result());
    if (wire::get_block(from, entry, "entry")) return entry;
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
  return broker.call(broker_operation("enlist"), block_size(entry) + sizeof seconds,
                     [&](wire::Encoder& to) {
                       put_block(to, entry);
                       to.put(seconds);
                     },
                     {});
}

tl::expected<Duration, NotRegistered> await_registered(CommandCore& asked, TimePoint deadline) {
  if (!asked.wait_until(deadline)) {
    return tl::unexpected(NotRegistered{false, {}, false, "the broker did not answer in time"});
  }
  if (asked.progress().detail == Detail::Done) {
    wire::Decoder from(asked.result());
    std::optional<double> seconds;
    const bool said = wire::get_optional(
        from, seconds, "settles_in", [&](double& value) { return from.get(value, "settles_in"); });
    if (!said || !seconds) return Duration::zero();  // or a broker that does not know of it
    return longest_provisional(*seconds);
  }
  const Failure& failure = asked.failure();
  if (const auto taken = failure.as<NameTaken>()) {
    return tl::unexpected(NotRegistered{true, taken->by, false,
                                        "the name " + taken->name + " is taken by " + taken->by +
                                            "; end that one, or serve this under another name"});
  }
  return tl::unexpected(NotRegistered{false,
                                      {},
                                      failure.state() == State::ConnectionFailed ||
                                          failure.detail == Detail::Stopped,  // the broker ends
                                      "the broker did not take it: " + failure.text});
}

void unregister_object(ClientConnection& broker, const std::string& name) {
  const auto command = call_with_text(broker, "withdraw", name);
  command->wait_until(deadline_after(std::chrono::milliseconds(500)));
}

}  // namespace gecos::session
