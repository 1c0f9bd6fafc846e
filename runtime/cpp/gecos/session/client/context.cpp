#include "gecos/session/client/context.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "gecos/broker_interface.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/broker_client.hpp"
#include "gecos/session/client/connect.hpp"
#include "gecos/session/client/failover.hpp"

namespace gecos::session {

namespace {

/// The longest time of one attempt to reach a new broker at the address of a silent one.
constexpr Duration successor_patience = std::chrono::milliseconds(250);
/// The last heartbeat of a broker may have been read this much later than it was sent, because this
/// process did not run. After a longer pause, a server asks the broker anyway.
constexpr Duration longest_delay = std::chrono::milliseconds(600);

void append(std::string& list, const std::string& text) {
  list += (list.empty() ? "" : "; ") + text;
}

}  // namespace

Context::Context(std::shared_ptr<Runtime> runtime)
    : runtime_(std::move(runtime)),
      failover_(std::make_shared<Failover>(*this)),
      lab_file_(runtime_->options().lab_file) {}

Context::~Context() { failover_->end(); }

bool Context::keep(const std::shared_ptr<ClientConnection>& session) {
  const MutexLock lock(keeping_);
  if (closed_) return false;
  std::erase_if(kept_, [](const auto& known) { return known.expired(); });
  kept_.push_back(session);
  return true;
}

bool Context::closed() const {
  const MutexLock lock(keeping_);
  return closed_;
}

bool Context::closed_by(TimePoint deadline) {
  MutexLock lock(keeping_);
  return closing_.wait_until(lock, deadline, [this] {
    keeping_.assert_held();
    return closed_;
  });
}

void Context::close(Duration patience) {
  std::vector<std::shared_ptr<Closable>> open;
  {
    const MutexLock lock(keeping_);
    closed_ = true;
    closing_.notify_all();
    for (const auto& known : kept_) {
      if (auto session = known.lock()) open.push_back(std::move(session));
    }
    kept_.clear();
  }
  runtime_->close_all(open, patience);
  failover_->end();
}

tl::expected<access::LabBroker, std::string> Context::named_broker(TimePoint deadline) {
  if (const auto& named = runtime_->options().broker; !named.empty()) {
    return access::LabBroker{named};
  }
  const char* const variable = std::getenv("GECOS_BROKER");
  if (variable != nullptr && *variable != '\0') return access::LabBroker{variable};
  return lab_file_.broker(deadline);
}

std::vector<std::string> Context::broker_addresses(const access::LabBroker& named,
                                                   std::string& tried) {
  std::vector<std::string> addresses;
  const auto add_well_known = [&](media::Kind kind) {
    if (const auto opened = runtime_->medium(kind)) {
      addresses.push_back((*opened)->well_known_address(broker_name));
      std::ranges::move((*opened)->shared_addresses(broker_name), std::back_inserter(addresses));
    } else {
      append(tried, opened.error().text);
    }
  };
  const auto kind = media::kind_from(named.address);
  // A program that contains a broker belongs to that broker's laboratory, whatever the lab file of
  // the host says.
  const bool by_file = !named.place.empty();
  if (by_file && kind != media::Kind::Inproc) add_well_known(media::Kind::Inproc);
  if (kind) {  // only a medium's name, for example "lcm"
    add_well_known(*kind);
  } else if (!named.address.empty()) {
    addresses.push_back(named.address);
  } else {
    for (const media::Kind each : media::all_kinds()) {
      if (media::reach_of(each) != media::Reach::Network) add_well_known(each);
    }
  }
  return addresses;
}

tl::expected<std::shared_ptr<ClientConnection>, NoBroker> Context::broker(TimePoint deadline) {
  MutexLock lock(mutex_);
  const auto settled = [this] {
    mutex_.assert_held();
    return knows_broker() || !looking_;
  };
  if (!looked_.wait_until(lock, deadline, settled)) {
    return tl::unexpected(
        NoBroker{"no broker was found in time: another thread of this program is looking for one" +
                 (missing_.empty() ? std::string() : "; the last search failed: " + missing_)});
  }
  // If another thread is looking for the successor of a silent broker, the session with that broker
  // serves this caller.
  if (looking_ || (knows_broker() && !broker_->may_have_ended())) return broker_;
  // If the session with the old broker is lost, it is destroyed at the end of this function, while
  // the mutex is not held.
  const auto old = broker_;
  if (old && old->lost()) broker_.reset();
  const bool silent = broker_ != nullptr;
  looking_ = true;
  lock.unlock();
  tl::expected<std::shared_ptr<ClientConnection>, NoBroker> found;
  try {
    if (silent) found = successor_of(old, deadline);
    if (!silent || (*found)->lost()) found = look_for_broker(deadline);
  } catch (...) {
    note_broker(silent ? old : nullptr, {});
    throw;
  }
  note_broker(found.value_or(nullptr), found ? std::string() : found.error().text);
  return found;
}

std::shared_ptr<ClientConnection> Context::successor_of(std::shared_ptr<ClientConnection> silent,
                                                        TimePoint deadline) {
  const TimePoint give_up = std::min(deadline, deadline_after(successor_patience));
  const auto found = connect(*runtime_, silent->place(), BrokerInterface::description, give_up);
  if (!found || (*found)->welcome().incarnation == silent->welcome().incarnation) return silent;
  // Two hosts may each have a broker at this address. Only a broker that has started since the
  // silent one was last heard has taken its place.
  const auto age = running_for(**found, give_up);
  if (!age || *age > silent->unheard_for() + longest_delay) return silent;
  silent->give_up("another broker has started at " + silent->place());
  return *found;
}

bool Context::knows_broker() const { return broker_ && !broker_->lost(); }

void Context::note_broker(std::shared_ptr<ClientConnection> found, std::string missing) {
  const MutexLock lock(mutex_);
  broker_ = std::move(found);
  missing_ = std::move(missing);
  looking_ = false;
  looked_.notify_all();
}

tl::expected<std::shared_ptr<ClientConnection>, NoBroker> Context::look_for_broker(
    TimePoint deadline) {
  std::string tried;
  std::string refused;
  const auto named = named_broker(deadline);
  if (!named) return tl::unexpected(NoBroker{named.error()});
  const auto addresses = broker_addresses(*named, tried);
  for (const auto& address : addresses) {
    Detail why{};
    auto session = connect(*runtime_, address, BrokerInterface::description, deadline, &why);
    if (session) return *std::move(session);
    if (why == Detail::Refused) append(refused, session.error());
    // Most programs contain no broker. Therefore the message mentions a broker in this program only
    // if the address of that broker was named.
    const bool expected = addresses.size() > 1 && address != named->address &&
                          why == Detail::NoServer && media::kind_of(address) == media::Kind::Inproc;
    if (!expected) append(tried, session.error());
  }
  if (!refused.empty()) {
    return tl::unexpected(
        NoBroker{"the broker refuses this program: " + refused, BrokerAnswer::Refused});
  }
  if (!named->place.empty()) append(tried, named->place + " names this address");
  return tl::unexpected(NoBroker{
      "no broker answers; start `gecos up` (a laboratory on this machine) or `gecos broker`, or "
      "give the broker's address in GECOS_BROKER or below [broker] in the lab file" +
      (tried.empty() ? std::string() : " (tried " + tried + ")")});
}

}  // namespace gecos::session
