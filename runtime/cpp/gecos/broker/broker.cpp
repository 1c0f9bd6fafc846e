#include "gecos/broker/broker.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <random>
#include <system_error>
#include <tuple>
#include <utility>
#include <variant>

#include "gecos/access/access_policy.hpp"
#include "gecos/base/log.hpp"
#include "gecos/base/seconds.hpp"
#include "gecos/base/thread.hpp"
#include "gecos/base/whole_characters.hpp"
#include "gecos/binding.hpp"
#include "gecos/broker/names.hpp"

namespace gecos::broker {
namespace {

/// Returns how long a server must be silent before the broker ends the session with that server.
Duration silence_that_ends_a_session() {
  const LabOptions standard;
  return standard.lease_ttl + standard.grace;
}

/// The longest expected time between the moment at which the kernel closes the sockets of a dead
/// process and the moment at which it reports the end of the process.
constexpr Duration death_is_reported_within = std::chrono::milliseconds(100);

/// Returns a random number that identifies this run of the broker.
std::uint64_t draw_life() {
  std::random_device random;
  return std::uint64_t{random()} << 32U | random();
}

}  // namespace

Broker::Broker(const BrokerOptions& options)
    : options_(options), directory_(new_directory(DirectoryOptions().young)) {}

Broker::~Broker() {
  if (!watcher_.joinable()) return;
  {
    const MutexLock lock(mutex_);
    ended_ = true;
  }
  wake_watcher_->notify();
  watcher_.join();
}

Directory Broker::new_directory(Duration young) const {
  return Directory(SystemClock().since_boot(), {young, options_.name_hold, draw_life()});
}

void Broker::start_threads() {
  visitor_lists_.start();
  if (!watcher_.joinable()) {
    {
      const MutexLock lock(mutex_);
      processes_.emplace();
    }
    wake_watcher_.emplace();
    watcher_ = start_thread("gecos-processes", [this] { watch_processes(); });
  }
}

void Broker::watch_processes() {
  std::array<pollfd, 2> descriptors{};
  {
    const MutexLock lock(mutex_);
    descriptors = {pollfd{wake_watcher_->descriptor(), POLLIN, 0},
                   pollfd{processes_->descriptor(), POLLIN, 0}};
  }
  Duration rest{};
  for (;;) {
    const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(rest).count();
    ::poll(descriptors.data(), descriptors.size(), static_cast<int>(milliseconds));
    wake_watcher_->drain();
    const TimePoint look_again = visitor_lists_.refresh_revoked(SystemClock().since_boot());
    const TimePoint now = SystemClock().since_boot();
    const MutexLock lock(mutex_);
    if (ended_) return;
    remove_ended();
    rest = end_due_sessions(now);
    rest = std::min({rest, directory_.on_tick(now) - now, look_again - now});
    rest = std::max(rest, Duration::zero());
    announce();
    const bool dropped = visitor_lists_.visitors()->book.keep_only([&](const std::string& name) {
      mutex_.assert_held();
      return directory_.keeps_name(name, now);
    });
    if (dropped) publish_revision(directory_.revision());
  }
}

Duration Broker::end_due_sessions(TimePoint now) {
  Duration rest = std::chrono::minutes(1);
  std::erase_if(ended_sessions_, [&](const EndedSession& one) {
    if (now < one.due) {
      rest = std::min(rest, one.due - now);
      return false;
    }
    mutex_.assert_held();
    end_session(one.session, one.heard);
    return true;
  });
  return rest;
}

void Broker::end_session(std::uint64_t session, TimePoint heard) {
  for (const auto& name : directory_.end_session(session, heard))
    log_info("broker", name + " left the list of objects, because its server is silent");
}

void Broker::remove_ended() {
  for (const std::int32_t pid : processes_->take_ended()) {
    for (const auto& name : directory_.process_ended(pid))
      log_info("broker",
               name + " was removed: its process, pid " + std::to_string(pid) + ", ended");
  }
  announce();
}

void Broker::forget_unused_processes() {
  for (const std::int32_t pid : processes_->watched()) {
    if (!directory_.uses_process(pid)) processes_->forget(pid);
  }
}

void Broker::announce() {
  const TimePoint now = SystemClock().since_boot();
  const ListRevision revision = directory_.revision();
  const bool settled = directory_.has_settled(now);
  const bool changed = std::exchange(announced_.number, revision.number) != revision.number;
  const bool settles = std::exchange(announced_.settled, settled) != settled;
  if (kept_ && (changed || settles)) kept_->keep(directory_.of_this_host(now), *processes_);
  if (changed) publish_revision(revision);
}

void Broker::expect_known(const std::vector<media::Kind>& media) {
  kept_.reset();
  const auto over_shm = [](media::Kind kind) { return reach_of(kind) == media::Reach::Host; };
  if (!media.empty() && std::ranges::none_of(media, over_shm)) return;
  const std::string directory = media::runtime_directory();
  if (directory.empty()) return;
  kept_.emplace(directory + "/BROKER.names");
  for (const Entry& entry : kept_->living(*processes_)) directory_.expect(entry);
}

Serving Broker::serving(std::vector<media::Kind> media) {
  start_threads();
  ObjectOptions options;
  options.simulated = true;  // a broker moves nothing, so it cannot cause harm
  options.well_known = true;
  options.visitors = visitor_lists_.visitors();
  // If only this process can use these media, no server has served an object before this broker
  // started, so the broker's answers need not be provisional.
  const bool alone = media::within_process(media);
  {
    const MutexLock lock(mutex_);
    directory_ = new_directory(alone ? Duration::zero() : DirectoryOptions().young);
    expect_known(media);
  }
  wake_watcher_->notify();
  options.media = std::move(media);
  return {"BROKER", *this, std::move(options)};
}

tl::expected<void, ServeError> Broker::serve(Server& server, std::vector<media::Kind> media) {
  try {
    Serving broker = serving(std::move(media));
    return server.add(std::move(broker.name), *this, std::move(broker.options));
  } catch (const std::system_error& why) {
    return tl::unexpected(ServeError{session::nothing_left("a broker", why)});
  }
}

void Broker::gecos_dispatch(IncomingCall call) {
  calling_ = {call.caller().session, call.caller().incarnation, call.core()};
  BrokerServant::gecos_dispatch(std::move(call));
  calling_.call.reset();
}

View Broker::view() const {
  return View(directory_, visitor_lists_.visitors()->book, session::visitor_of(*calling_.call));
}

Result<std::optional<double>> Broker::enlist(const Entry& told, double served_for,
                                             const std::optional<AdmittedNames>& admitted,
                                             const std::optional<double>& confirmed_ago) {
  if (auto why = why_not_listed(told, admitted); !why.empty()) {
    return tl::unexpected(Fault::rejected(std::move(why)));
  }
  visitor_lists_.ensure_revoked_known(admitted);
  const auto user = session::other_user_of(*calling_.call);
  Entry what = told;
  if (user) std::tie(what.user, what.hostname) = std::tie(user->who.user, user->who.host);
  const MutexLock lock(mutex_);
  if (!directory_.has(calling_.session, what.name)) {
    std::string why = session::refusal_to_register(*calling_.call, what.name);
    if (!why.empty()) return tl::unexpected(Fault::rejected(std::move(why)));
  }
  remove_ended();
  const bool says_pid = !user || !user->pid || *user->pid == what.pid;
  const bool here = says_pid && session::sees_process(what) && processes_->watch(what.pid);
  Claim claim{calling_.session, calling_.incarnation, from_seconds(served_for),
              here ? Host::Same : Host::Other};
  if (confirmed_ago && *confirmed_ago >= 0) claim.confirmed_ago = from_seconds(*confirmed_ago);
  const auto before = directory_.look_up(what.name);
  const auto provisional = directory_.enlist(claim, what, SystemClock().since_boot());
  if (!provisional) {
    forget_unused_processes();
    return tl::unexpected(Fault(provisional.error()));
  }
  announce();
  if (visitor_lists_.set(what, user, admitted, directory_.revision().number)) {
    // The list that a visitor sees may have changed, although the list that other clients see has
    // not changed.
    publish_revision(directory_.revision());
    wake_watcher_->notify();
  }
  if (!before) {
    log_info("broker", what.name + " was enlisted with the interface " + what.interface_name);
  } else if (*before != what) {
    log_warning("broker", what.name + " now belongs to the server with pid " +
                              std::to_string(what.pid) + " on " + what.hostname +
                              ", whose claim to it is better than that of pid " +
                              std::to_string(before->pid) + " on " + before->hostname);
  }
  if (*provisional == Duration::zero()) return std::nullopt;
  return to_seconds(*provisional);
}

Result<void> Broker::withdraw(const std::string& name) {
  const MutexLock lock(mutex_);
  if (auto gone = directory_.withdraw(calling_.session, name); !gone) {
    return tl::unexpected(Fault(gone.error()));
  }
  forget_unused_processes();
  announce();
  log_info("broker", name + " was withdrawn");
  return {};
}

Result<Entry> Broker::lookup(const std::string& name) {
  const MutexLock lock(mutex_);
  remove_ended();
  auto found = view().look_up(name);
  if (!found) {
    // The name is shortened to limit the size of the reply.
    found.error().name = whole_characters(name, access::longest_name);
    return tl::unexpected(Fault(found.error()));
  }
  return *std::move(found);
}

Result<std::vector<Entry>> Broker::list() {
  const MutexLock lock(mutex_);
  remove_ended();
  return view().list();
}

Result<std::vector<Entry>> Broker::query(const std::string& interface_name) {
  const MutexLock lock(mutex_);
  remove_ended();
  return view().query(interface_name);
}

Result<ListChanges> Broker::changes(const ListRevision& since) {
  const MutexLock lock(mutex_);
  remove_ended();
  return view().changes(since, SystemClock().since_boot());
}

Result<ListRevision> Broker::revision() {
  const MutexLock lock(mutex_);
  remove_ended();
  return view().revision();
}

Result<void> Broker::free(const std::string& name) {
  const MutexLock lock(mutex_);
  remove_ended();
  if (auto freed = directory_.free(name); !freed) {
    return std::visit([](const auto& why) -> Result<void> { return tl::unexpected(Fault(why)); },
                      freed.error());
  }
  announce();
  log_warning("broker", "the name " + name + " was freed although no server had withdrawn it");
  return {};
}

Result<std::vector<SilentObject>> Broker::silent() {
  const TimePoint now = SystemClock().since_boot();
  const MutexLock lock(mutex_);
  remove_ended();
  std::vector<SilentObject> objects;
  for (Silent& one : view().silent(now)) {
    const auto free_in = directory_.free_in(one, now);
    objects.push_back({std::move(one.entry), to_seconds(now - one.since),
                       free_in ? std::optional(to_seconds(*free_in)) : std::nullopt});
  }
  return objects;
}

Result<RevocationList> Broker::revocations(std::uint64_t applied) {
  const auto list = visitor_lists_.revoked().read();
  if (!list) return tl::unexpected(Fault::rejected(list.error()));
  {
    const MutexLock lock(mutex_);
    applied_[calling_.session] = applied;
  }
  RevocationList told{(*list)->number, (*list)->number != applied, {}};
  if (told.changed) {
    for (const auto& one : (*list)->revoked) told.revoked.push_back({one.key, one.owner});
  }
  return told;
}

Result<RevocationState> Broker::behind(const std::vector<Revocation>& revoked) {
  const auto list = visitor_lists_.revoked().read();
  if (!list) return tl::unexpected(Fault::rejected(list.error()));
  RevocationState state;
  state.listed = std::ranges::all_of(revoked, [&](const Revocation& one) {
    const access::RevokedUser wanted{one.key, one.owner};
    return std::ranges::find((*list)->revoked, wanted) != (*list)->revoked.end();
  });
  const MutexLock lock(mutex_);
  remove_ended();
  state.behind = directory_.names_of([&](std::uint64_t session) {
    mutex_.assert_held();
    const auto found = applied_.find(session);
    return found == applied_.end() || found->second != (*list)->number;
  });
  return state;
}

void Broker::gecos_session_ended(std::uint64_t session) {
  const TimePoint now = SystemClock().since_boot();
  const TimePoint heard = now - silence_that_ends_a_session();
  const MutexLock lock(mutex_);
  applied_.erase(session);
  remove_ended();
  if (directory_.is_of_this_host(session)) {
    ended_sessions_.push_back({session, heard, now + death_is_reported_within});
  } else {
    end_session(session, heard);
    announce();
  }
  wake_watcher_->notify();
}

}  // namespace gecos::broker
