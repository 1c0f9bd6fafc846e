#include <algorithm>
#include <chrono>
#include <utility>

#include "gecos/base/seconds.hpp"
#include "gecos/binding.hpp"
#include "gecos/builtin_operations.hpp"
#include "gecos/object_calls.hpp"      // generated from idl/gecos/object.gidl
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/client/own_call.hpp"

namespace gecos::session {

std::shared_ptr<CommandCore> ask_for_status(ClientSession& session, Status wanted,
                                            const std::string& password, Duration timeout) {
  const media::Capabilities& line = session.capabilities();
  if (!password.empty() && !line.authenticated) {
    return ended({Detail::BadParameter,
                  session.object_name() + ": the password was not sent over " +
                      std::string(line.name) + ", because nothing proves who receives it",
                  {},
                  {}});
  }
  GecosObject_acquire_arguments arguments{wanted};
  if (!password.empty()) arguments.password = password;
  arguments.patience = to_seconds(std::max(timeout, Duration::zero()));
  return own_call(session, GecosObjectInterface::acquire, arguments);
}

tl::expected<Lease, LeaseRefusal> lease_from(const std::shared_ptr<ClientSession>& session,
                                             CommandCore& asked) {
  asked.observe();
  if (asked.progress().detail != Detail::Done) {
    LeaseRefusal refusal{asked.failure(), {}};
    if (auto refused = refusal.failure.as<StatusRefused>()) {
      refusal.holders = std::move(refused->holders);
    }
    return tl::unexpected(std::move(refusal));
  }
  Grant grant;
  wire::Decoder from(asked.result());
  if (!read_result<GecosObject_acquire_result>(from, grant)) {
    return tl::unexpected(LeaseRefusal{
        {Detail::Fault, "the reply does not decode: " + from.error().message(), {}, {}}, {}});
  }
  return Lease(session, grant);
}

void decline_status(const std::shared_ptr<ClientSession>& session,
                    const std::shared_ptr<CommandCore>& asked) {
  asked->cancel();
  asked->when_ended([session, asked] {
    if (auto lease = lease_from(session, *asked)) lease->release_now();
  });
}

}  // namespace gecos::session
