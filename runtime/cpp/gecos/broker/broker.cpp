#include "gecos/broker/broker.hpp"

#include "gecos/base/log.hpp"

namespace gecos::broker {

tl::expected<void, ServeError> Broker::serve(Server& server, std::vector<media::Kind> media) {
  ObjectOptions options;
  options.simulated = true;  // there is nothing that could hurt anybody
  options.well_known = true;
  options.media = std::move(media);
  return server.add("BROKER", *this, std::move(options));
}

void Broker::gecos_dispatch(IncomingCall call) {
  calling_ = {call.caller().session, call.caller().boot};
  BrokerServant::gecos_dispatch(std::move(call));
}

Result<void> Broker::enlist(const Entry& what) {
  const std::lock_guard lock(mutex_);
  if (auto added = directory_.enlist(calling_.session, calling_.boot, what); !added) {
    return tl::unexpected(Fault(added.error()));
  }
  log_info("broker", what.name + " is a " + what.interface_name);
  return {};
}

Result<void> Broker::withdraw(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (auto gone = directory_.withdraw(calling_.session, name); !gone) {
    return tl::unexpected(Fault(gone.error()));
  }
  log_info("broker", name + " was withdrawn");
  return {};
}

Result<Entry> Broker::lookup(const std::string& name) {
  const std::lock_guard lock(mutex_);
  auto found = directory_.look_up(name);
  if (!found) return tl::unexpected(Fault(found.error()));
  return *std::move(found);
}

Result<std::vector<Entry>> Broker::list() {
  const std::lock_guard lock(mutex_);
  return directory_.list();
}

void Broker::gecos_session_ended(std::uint64_t session) {
  const std::lock_guard lock(mutex_);
  for (const auto& name : directory_.end_session(session)) {
    log_info("broker", name + " is gone with its server");
  }
}

}  // namespace gecos::broker
