#include "gecos/session/client/subscriptions.hpp"

#include "gecos/object_calls.hpp"      // generated from idl/gecos/object.gidl
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/client_stream.hpp"
#include "gecos/session/client/own_call.hpp"
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {
tl::expected<std::shared_ptr<ClientStream>, Failure> Subscriptions::subscribe(
    const StreamDescription& stream, const ClientStream* earlier) {
  std::shared_ptr<CommandCore> command;
  {
    const MutexLock lock(mutex_);
    ++counts_[stream.code];
    streams_.store(counts_.size(), std::memory_order_relaxed);
    command = own_call(session_, GecosObjectInterface::subscribe,
                       GecosObject_subscribe_arguments{number(stream.code)});
  }
  auto opened = open(stream, *command, earlier);
  if (!opened) unsubscribe(stream.code);
  return opened;
}

tl::expected<std::shared_ptr<ClientStream>, Failure> Subscriptions::open(
    const StreamDescription& stream, CommandCore& subscribed, const ClientStream* earlier) {
  subscribed.wait_until(TimePoint::max());
  const std::string what = "stream '" + std::string(stream.name) + "' of " + session_.object_name();
  if (subscribed.progress().detail != Detail::Done) {
    Failure failure = subscribed.failure();
    if (failure.detail == Detail::UnknownOperation) {
      failure.text = "the server has no " + what +
                     " and may be older than this program's interface: " + failure.text;
    }
    return tl::unexpected(std::move(failure));
  }
  Subscription answer;
  if (wire::Decoder from(subscribed.result());
      !read_result<GecosObject_subscribe_result>(from, answer)) {
    return tl::unexpected(
        Failure{Detail::Fault, "the reply does not decode: " + from.error().message(), {}, {}});
  }
  media::Connection& connection = session_.connection();
  std::unique_ptr<media::StreamReader> reader;
  const std::uint32_t id = answer.stream;
  std::string impossible;
  session_.reader().wait(
      nullptr,
      [&] {
        if (!reader) reader = connection.open_stream(id);
        if (!reader) impossible = connection.why_no_stream(id);
        return reader != nullptr || !impossible.empty() || session_.lost();
      },
      deadline_after(session_.runtime().options().grace));
  if (!reader && !impossible.empty()) {
    return tl::unexpected(Failure{
        Detail::Refused, what + " cannot be opened in this process: " + impossible, {}, {}});
  }
  if (!reader) {
    return tl::unexpected(Failure{
        Detail::OutcomeUnknown,
        what + " could not be opened in time over " + std::string(connection.capabilities().name),
        {},
        {}});
  }
  return std::make_shared<ClientStream>(session_.shared_from_this(), stream, std::move(reader),
                                        answer.newest, earlier);
}

void Subscriptions::unsubscribe(FunctionCode stream) {
  const MutexLock lock(mutex_);
  const auto found = counts_.find(stream);
  if (--found->second != 0) return;
  counts_.erase(found);
  streams_.store(counts_.size(), std::memory_order_relaxed);
  if (session_.lost()) return;
  own_call(session_, GecosObjectInterface::unsubscribe,
           GecosObject_unsubscribe_arguments{number(stream)})
      ->observe();
}

}  // namespace gecos::session
