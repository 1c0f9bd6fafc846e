#include "gecos/session/server/builtin_operations.hpp"

#include <unistd.h>

#include <string_view>
#include <utility>
#include <vector>

#include "gecos/base/log.hpp"
#include "gecos/object_calls.hpp"      // generated from idl/gecos/object.gidl
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/server/call_log.hpp"
#include "gecos/session/server/object_host.hpp"
#include "gecos/session/server/object_stats.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::session {
namespace {

Failure undecodable(const wire::DecodeError& why) {
  return {Detail::BadParameter, why.message(), {}, {}};
}

}  // namespace

void BuiltinOperations::answer(const std::shared_ptr<ServerSession>& session,
                               const wire::PacketView& packet) {
  const std::uint64_t counter = packet.header.counter;
  using BuiltIn = GecosObjectInterface;
  const ByteView arguments = packet.body;
  const OperationDescription* const asked = BuiltIn::description.find(packet.header.code);
  if (asked == &BuiltIn::holders) return holders(*session, counter);
  if (asked == &BuiltIn::stop) return stop(*session, counter);
  if (asked == &BuiltIn::ping) return session->reply(counter, ByteView{});
  if (asked == &BuiltIn::describe) return describe(*session, counter);
  if (asked == &BuiltIn::model) return model(*session, counter);
  if (asked == &BuiltIn::stats) return stats(*session, counter);
  if (asked == &BuiltIn::roster) return roster(session, counter, arguments);
  if (asked == &BuiltIn::acquire) return acquire(session, counter, arguments);
  if (asked == &BuiltIn::release) return release(*session, counter, arguments);
  if (asked == &BuiltIn::take_over) return take_over(*session, counter);
  if (asked == &BuiltIn::give_back) return give_back(*session, counter);
  if (asked == &BuiltIn::requests) return requests(session, counter, arguments);
  if (asked == &BuiltIn::deny) return deny(*session, counter, arguments);
  if (asked == &BuiltIn::break_status) return break_status(*session, counter, arguments);
  if (asked == &BuiltIn::subscribe) return subscribe(*session, counter, arguments);
  if (asked == &BuiltIn::unsubscribe) return unsubscribe(*session, counter, arguments);
  if (asked == &BuiltIn::feed) return feed(session, counter, arguments);
  if (asked == &BuiltIn::end_feed) return end_feed(*session, counter, arguments);
  if (asked == &BuiltIn::feed_report) return feed_report(*session, counter, arguments);
  session->reply(counter, Failure{Detail::UnknownOperation,
                                  "the built-in operation with code " +
                                      std::to_string(number(packet.header.code)) +
                                      " is newer than this server; update the server",
                                  {},
                                  {}});
}

void BuiltinOperations::holders(ServerSession& session, std::uint64_t counter) {
  session.reply(counter,
                layout::to_bytes(GecosObject_holders_result{statuses_.roster().holders()}));
}

void BuiltinOperations::describe(ServerSession& session, std::uint64_t counter) {
  Description about;
  about.name = setup_.name;
  about.interface_name = setup_.interface.name;
  about.version = setup_.interface.version;
  about.interface_hash = setup_.interface.hash;
  about.simulated = setup_.options.simulated;
  about.presence = "not checked: the object is in no zone";
  if (presence_.required()) {
    about.presence = presence_.text(setup_.clock().since_boot());
  } else if (setup_.options.simulated) {
    about.presence = "not required (simulated)";
  }
  about.authentication = "this process";
  if (session.connection().peer().uid) {
    about.authentication = "user and process, named by the kernel";
  } else if (session.connection().capabilities().reach == media::Reach::Network) {
    about.authentication = "key, proved by a handshake: " + session.connection().peer().description;
  }
  if (setup_.rights.everybody_connects) {
    about.authentication += "; --insecure: every user of every host may connect";
  }
  about.pid = getpid();
  about.registration = claim_.text();
  if (session.visit.visitor() == nullptr) {  // a visitor does not learn what other clients do
    about.epoch = number(statuses_.leases().epoch());
    about.queued = static_cast<std::uint32_t>(calls_.queue().waiting().size());
    if (!calls_.queue().running().empty())
      about.executing = calls_.queue().running().front()->operation.name;
    about.handlers = calls_.handlers().shown(setup_.clock().since_boot());
  }
  session.reply(counter, layout::to_bytes(GecosObject_describe_result{std::move(about)}));
}

void BuiltinOperations::model(ServerSession& session, std::uint64_t counter) {
  const std::vector<std::string_view> models = setup_.interface.all_models();
  session.reply(counter,
                layout::to_bytes(GecosObject_model_result{{models.begin(), models.end()}}));
}

void BuiltinOperations::stats(ServerSession& session, std::uint64_t counter) {
  session.reply(counter, layout::to_bytes(GecosObject_stats_result{
                             stats_of(*session.object(), calls_, setup_.clock().now())}));
}

void BuiltinOperations::roster(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                               ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_roster_arguments>(arguments);
  if (!asked) return session->reply(counter, undecodable(asked.error()));
  statuses_.roster().ask(session, counter, *asked);
}

void BuiltinOperations::acquire(const std::shared_ptr<ServerSession>& session,
                                std::uint64_t counter, ByteView arguments) {
  auto asked = layout::from_bytes<GecosObject_acquire_arguments>(arguments);
  if (!asked) return session->reply(counter, undecodable(asked.error()));
  statuses_.request(session, counter, *std::move(asked));
}

void BuiltinOperations::release(ServerSession& session, std::uint64_t counter, ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_release_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  statuses_.release(session, *asked);
  session.reply(counter, ByteView{});
}

void BuiltinOperations::take_over(ServerSession& session, std::uint64_t counter) {
  if (const auto refused = statuses_.take_over(session)) return session.reply(counter, *refused);
  session.reply(counter, ByteView{});
}

void BuiltinOperations::give_back(ServerSession& session, std::uint64_t counter) {
  statuses_.give_back(session);
  session.reply(counter, ByteView{});
}

void BuiltinOperations::refuse(ServerSession& session, std::uint64_t counter,
                               const OperationDescription& asked, const std::string& why) {
  const Failure refused =
      status_refusal(setup_.name + ": " + why + named_request(session.id(), counter),
                     statuses_.roster().holders());
  setup_.audit->refused(session, counter, asked.code, asked.name, refused);
  session.reply(counter, refused);
}

void BuiltinOperations::requests(const std::shared_ptr<ServerSession>& session,
                                 std::uint64_t counter, ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_requests_arguments>(arguments);
  if (!asked) return session->reply(counter, undecodable(asked.error()));
  statuses_.line().ask(session, counter, *asked);
}

void BuiltinOperations::deny(ServerSession& session, std::uint64_t counter, ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_deny_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  const access::LeaseTable& leases = statuses_.leases();
  if (leases.status_of(session.id()) == access::Status::Sensor || leases.releasing(session.id())) {
    return refuse(session, counter, GecosObjectInterface::deny,
                  "only a client that holds the status may deny it to others");
  }
  const std::string denial = "the status is refused by its holder, " + who(session.caller()) +
                             (asked->why.empty() ? "" : ": " + asked->why);
  const bool waited = statuses_.deny(asked->request, denial);
  if (waited) log_info("server", setup_.name + ": " + denial);
  session.reply(counter, layout::to_bytes(GecosObject_deny_result{waited}));
}

void BuiltinOperations::break_status(ServerSession& by, std::uint64_t counter, ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_break_status_arguments>(arguments);
  if (!asked) return by.reply(counter, undecodable(asked.error()));
  if (!setup_.rights.administers(by.connection().peer())) {
    return refuse(by, counter, GecosObjectInterface::break_status,
                  "only an administrator may break a status: the user of the server, root, and "
                  "the users in [admin] of the lab file");
  }
  const std::string why = "an administrator, " + who(by.caller()) + ", broke it" +
                          (asked->why.empty() ? "" : ": " + asked->why);
  log_warning("server", setup_.name + ": " + why);
  statuses_.break_all(why);
  by.reply(counter, ByteView{});
}

/// A stop takes effect at once even if handlers hang, because it changes only the leases, the queue
/// and the interrupt flags of the handlers.
void BuiltinOperations::stop(ServerSession& by, std::uint64_t counter) {
  const std::string why = "stopped by " + who(by.caller());
  log_info("server", setup_.name + ": " + why);
  setup_.audit->stopped(by, counter);
  statuses_.stop(by.id(), why);
  calls_.end_commands([](const ServerCall&) { return true; },
                      Failure{Detail::Stopped, why, {}, {}});
  if (setup_.options.on_stop) user_callbacks_.post(setup_.options.on_stop);
  by.reply(counter, ByteView{});
}

void BuiltinOperations::subscribe(ServerSession& session, std::uint64_t counter,
                                  ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_subscribe_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  const StreamDescription* stream = setup_.interface.find_stream(FunctionCode{asked->code});
  if (stream == nullptr) {
    return session.reply(counter,
                         Failure{Detail::UnknownOperation,
                                 setup_.name + " (" + std::string(setup_.interface.name) +
                                     ") has no stream with code " + std::to_string(asked->code),
                                 {},
                                 {}});
  }
  const auto may = statuses_.leases().may_queue(session.id(), statuses_.leases().epoch(),
                                                stream->status, statuses_.now());
  if (!may) {
    const Failure denied{Detail::Denied,
                         "stream '" + std::string(stream->name) + "' of " + setup_.name + " " +
                             may.error().text + named_request(session.id(), counter),
                         {},
                         {}};
    setup_.audit->refused(session, counter, stream->code, stream->name, denied);
    return session.reply(counter, denied);
  }
  const auto shared = session.share(*stream);
  if (!shared) return session.reply(counter, Failure{Detail::Rejected, shared.error(), {}, {}});
  session.subscriptions[stream->code] = shared->stream;
  session.reply(counter, layout::to_bytes(GecosObject_subscribe_result{*shared}));
}

InwardPort* BuiltinOperations::inward_port(ServerSession& session, std::uint64_t counter,
                                           FunctionCode code) {
  InwardPort* const port = session.object()->inward().find(code);
  if (port == nullptr) {
    session.reply(counter,
                  Failure{Detail::UnknownOperation,
                          setup_.name + " (" + std::string(setup_.interface.name) +
                              ") has no inward stream with code " + std::to_string(number(code)),
                          {},
                          {}});
  }
  return port;
}

void BuiltinOperations::feed(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                             ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_feed_arguments>(arguments);
  if (!asked) return session->reply(counter, undecodable(asked.error()));
  InwardPort* const port = inward_port(*session, counter, FunctionCode{asked->code});
  if (port == nullptr) return;
  const auto opened = session->object()->inward().feed(*port, session, asked->stream);
  if (!opened) return session->reply(counter, Failure{Detail::Rejected, opened.error(), {}, {}});
  if (*opened) statuses_.note_feeder(session);
  session->reply(counter, layout::to_bytes(GecosObject_feed_result{*opened}));
}

void BuiltinOperations::end_feed(ServerSession& session, std::uint64_t counter,
                                 ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_end_feed_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  InwardPort* const port = inward_port(session, counter, FunctionCode{asked->code});
  if (port == nullptr) return;
  port->end(session.id(), asked->stream);
  session.reply(counter, ByteView{});
}

void BuiltinOperations::feed_report(ServerSession& session, std::uint64_t counter,
                                    ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_feed_report_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  InwardPort* const port = inward_port(session, counter, FunctionCode{asked->code});
  if (port == nullptr) return;
  session.reply(counter,
                layout::to_bytes(GecosObject_feed_report_result{port->report_of(session.id())}));
}

void BuiltinOperations::unsubscribe(ServerSession& session, std::uint64_t counter,
                                    ByteView arguments) {
  const auto asked = layout::from_bytes<GecosObject_unsubscribe_arguments>(arguments);
  if (!asked) return session.reply(counter, undecodable(asked.error()));
  const auto found = session.subscriptions.find(FunctionCode{asked->code});
  if (found != session.subscriptions.end()) {
    session.unshare(found->second);
    session.subscriptions.erase(found);
  }
  session.reply(counter, ByteView{});
}

}  // namespace gecos::session
