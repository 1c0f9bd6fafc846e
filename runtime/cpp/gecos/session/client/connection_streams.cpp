// How the client side of a session subscribes to streams.
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/client_stream.hpp"
#include "gecos/session/client/own_call.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {

tl::expected<std::shared_ptr<StreamCore>, Failure> ClientConnection::subscribe(
    const StreamDescription& stream) {
  std::shared_ptr<CommandCore> command;
  if (auto refused = differs(stream.code, stream.name)) return tl::unexpected(std::move(*refused));
  {
    const MutexLock lock(subscribing_);
    ++subscriptions_[stream.code];
    command = own_call(*this, GecosObjectInterface::subscribe,
                       GecosObject_subscribe_arguments{number(stream.code)});
  }
  auto opened = open_subscribed(stream, *command);
  if (!opened) unsubscribe(stream.code);
  return opened;
}

tl::expected<std::shared_ptr<StreamCore>, Failure> ClientConnection::open_subscribed(
    const StreamDescription& stream, CommandCore& subscribed) {
  subscribed.wait_until(TimePoint::max());
  if (subscribed.progress().detail != Detail::Done) return tl::unexpected(subscribed.failure());
  std::uint32_t id = 0;
  if (wire::Decoder from(subscribed.result());
      !read_result<GecosObject_subscribe_result>(from, id)) {
    return tl::unexpected(
        Failure{Detail::Fault, "the reply does not decode: " + from.error().message(), {}, {}});
  }
  std::unique_ptr<media::StreamReader> reader;
  std::string impossible;
  wait(
      nullptr,
      [&] {
        if (!reader) reader = open_stream(id);
        if (!reader) impossible = connection_->why_no_stream(id);
        return reader != nullptr || !impossible.empty() || lost();
      },
      deadline_after(runtime_->options().grace));
  const std::string what = "stream '" + std::string(stream.name) + "' of " + welcome_.object;
  if (!reader && !impossible.empty()) {
    return tl::unexpected(Failure{
        Detail::Refused, what + " cannot be opened in this process: " + impossible, {}, {}});
  }
  if (!reader) {
    return tl::unexpected(
        Failure{Detail::OutcomeUnknown,
                what + " did not arrive over " + std::string(connection_->capabilities().name),
                {},
                {}});
  }
  return std::make_shared<ClientStream>(shared_from_this(), stream.code, std::move(reader));
}

std::unique_ptr<media::StreamReader> ClientConnection::open_stream(std::uint32_t id) {
  return connection_->open_stream(id);
}

void ClientConnection::unsubscribe(FunctionCode stream) {
  const MutexLock lock(subscribing_);
  const auto found = subscriptions_.find(stream);
  if (--found->second != 0) return;
  subscriptions_.erase(found);
  if (lost()) return;
  own_call(*this, GecosObjectInterface::unsubscribe,
           GecosObject_unsubscribe_arguments{number(stream)})
      ->observe();
}

}  // namespace gecos::session
