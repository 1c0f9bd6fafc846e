#include "gecos/session/server/registrar.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <set>
#include <utility>

#include "gecos/access/visitors.hpp"
#include "gecos/base/log.hpp"
#include "gecos/base/pid_namespace.hpp"
#include "gecos/base/thread.hpp"
#include "gecos/binding.hpp"
#include "gecos/broker_interface.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/broker_client.hpp"
#include "gecos/session/client/connect.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {
namespace {

constexpr Duration patience = std::chrono::seconds(2);
/// The time for which the registrar's thread waits for a broker. Actor commands wait for the same
/// time. After this time, actor commands are refused because no broker answers.
constexpr Duration answer_patience = std::chrono::seconds(1);
constexpr Duration look_again_after = std::chrono::milliseconds(20);
/// While the broker is silent, the thread begins to look for a new one at most this often.
constexpr Duration between_looks = std::chrono::milliseconds(250);
/// A broker that does not answer is noticed as silent within this time.
constexpr Duration slice = std::chrono::milliseconds(50);
/// A missing broker is not reported before this time has passed, because server and broker are
/// often started together.
constexpr Duration report_after = std::chrono::seconds(1);

/// Returns whether other processes can find `entry`. If they can, the broker may assign the name to
/// another server.
bool others_find(const Entry& entry, const ClientConnection& broker) {
  const auto elsewhere = [](const std::string& address) {
    const auto kind = media::kind_of(address);
    return !kind || media::reach_of(*kind) != media::Reach::Process;
  };
  return elsewhere(broker.place()) && std::ranges::any_of(entry.addresses, elsewhere);
}

/// Waits for the answer to `asked`, a registration. Waits until `deadline`, but no longer once
/// `broker` may have ended, because a new broker must then be looked for.
tl::expected<Duration, NotRegistered> answer_of(const ClientConnection& broker, CommandCore& asked,
                                                TimePoint deadline) {
  TimePoint until{};
  do {
    until = std::min(deadline, deadline_after(slice));
  } while (!asked.wait_until(until) && until < deadline && !broker.may_have_ended());
  return await_registered(asked, until);
}

/// Returns a number for a list of admitted names. The number is greater than that of every earlier
/// list of this process. Two servers of one process may serve one name, one after the other, and
/// the broker keeps the list with the greater number.
std::uint64_t next_number() {
  static std::atomic<std::uint64_t> last{0};  // publishes nothing but itself
  return ++last;
}

void keep_first_of_each(std::vector<std::string>& names) {
  std::set<std::string> seen;  // copies: erase_if moves the names
  std::erase_if(names, [&](const auto& name) { return !seen.insert(name).second; });
}

}  // namespace

Registrar::Registrar(std::shared_ptr<Context> lab, std::shared_ptr<BrokerContact> contact,
                     std::shared_ptr<AccessControl> access)
    : lab_(std::move(lab)), contact_(std::move(contact)), access_(std::move(access)) {
  thread_ = start_thread("gecos-registrar", [this] { run(); });
}

tl::expected<void, std::string> Registrar::await_broker(TimePoint deadline) {
  AskPause pause;
  for (;;) {
    const auto broker = lab_->broker(std::min(deadline, deadline_after(patience)));
    note_broker(broker ? std::string() : broker.error().text);
    if (broker) return {};
    if (!rest(pause.after(broker.error().answer), deadline)) {
      return tl::unexpected(broker.error().text);
    }
  }
}

void Registrar::note_broker(const std::string& missing) {
  const TimePoint now = lab_->runtime()->clock().now();
  const MutexLock lock(mutex_);
  if (missing.empty()) {
    missing_since_.reset();
    reported_missing_ = false;
    return;
  }
  if (!missing_since_) missing_since_ = now;
  if (reported_missing_ || now < *missing_since_ + report_after) return;
  reported_missing_ = true;
  log_warning("session", missing +
                             "; this server goes on asking; until a broker answers, new clients "
                             "cannot find the objects of this server");
}

bool Registrar::rest(Duration length, TimePoint deadline) {
  const Clock& clock = lab_->runtime()->clock();
  MutexLock lock(mutex_);
  changed_.wait_until(lock, std::min(deadline, clock.now() + length), [this] {
    mutex_.assert_held();
    return ended_;
  });
  return !ended_ && clock.now() < deadline;
}

tl::expected<void, std::string> Registrar::add(const std::shared_ptr<ObjectHost>& object,
                                               std::vector<std::string> addresses) {
  const InterfaceDescription& interface = object->interface();
  const Hello self = lab_->runtime()->introduce(interface);
  Registration registration;
  Entry& entry = registration.entry;
  entry.name = object->name();
  entry.interface_name = interface.name;
  entry.bases.assign(interface.bases.begin(), interface.bases.end());
  entry.interface_hash = interface.hash;
  entry.boot = self.incarnation;
  entry.pid = self.pid;
  entry.user = self.user;
  entry.pid_namespace = pid_namespace();
  entry.host = lab_->runtime()->host_identity();
  entry.hostname = self.host;
  entry.addresses = std::move(addresses);
  entry.simulated = object->setup().options.simulated;
  registration.object = object;

  const auto enlisted = register_first(
      registration, deadline_after(std::max(patience, object->setup().options.patience)));
  if (!enlisted) return tl::unexpected(entry.name + " is not served: " + enlisted.error());
  const MutexLock lock(mutex_);
  registrations_.push_back(std::move(registration));
  const bool admits_others = renew(registrations_.back());
  note_reach(registrations_.back());
  const bool other_broker = broker_ != enlisted->by;  // which does not know the object
  if (enlisted->provisional > Duration::zero() || admits_others || other_broker) want(Work::Ask);
  return {};
}

void Registrar::note_reach(const Registration& registration) {
  const AdmittedNames& admitted = registration.admitted;
  if (noted_reach_ || (admitted.users.empty() && admitted.hosts.empty())) return;
  const Entry& entry = registration.entry;
  if (!broker_ || media::open_to_other_users()) return;
  const auto broker_user = broker_->connection().peer().uid;
  if (!broker_user || *broker_user == ::geteuid() || !others_find(entry, *broker_)) return;
  noted_reach_ = true;
  log_warning("session",
              "this server runs as " + entry.user +
                  ", but the broker runs as another user: programs of users other than " +
                  entry.user +
                  " can reach the objects of this server only over lcm, with an admitted key; "
                  "over shm they can reach only " +
                  std::string(media::servers_of_all_users));
}

/// Registers an object for the first time. Tries again when the broker is lost during the
/// registration, because a restarted broker accepts the same entry. Also tries again while the name
/// belongs to a server that has ended on this host, because a killed server may be restarted before
/// the broker notices its end. Also tries again while the name is held for a silent server that
/// loses the name before `deadline`.
tl::expected<Registrar::Registered, std::string> Registrar::register_first(
    Registration& registration, TimePoint deadline) {
  AskPause pause;
  for (;;) {
    const auto broker = find_broker(deadline);
    if (!broker) {
      if (rest(pause.after(broker.error().answer), deadline)) continue;
      return tl::unexpected(broker.error().text);
    }
    ObjectHost& object = *registration.object;
    contact_->renew(**broker, deadline);
    if (lab_->runtime()->clock().now() >= deadline) {
      return tl::unexpected(std::string("the broker did not answer in time"));
    }
    if (others_find(registration.entry, **broker)) object.name_confirmation().ask();
    const auto question = object.name_confirmation().question();
    registration.since = lab_->runtime()->clock().since_boot();
    {
      const MutexLock lock(mutex_);
      renew(registration);
    }
    const auto asked =
        register_object(**broker, registration.entry, Duration::zero(), registration.admitted);
    const auto enlisted = answer_of(**broker, *asked, deadline);
    if (enlisted) {
      if (*enlisted == Duration::zero()) {
        object.name_confirmation().held(question);
        registration.confirmed = registration.since;
      }
      return Registered{*enlisted, *broker};
    }
    const bool later = enlisted.error().unheard || (*broker)->lost() ||
                       (*broker)->may_have_ended() ||
                       (enlisted.error().taken && becomes_free(registration.entry.name, deadline));
    if (later && rest(look_again_after, deadline)) continue;
    if (asked->progress().detail < Detail::Done) take_back(**broker, registration.entry.name);
    return tl::unexpected(enlisted.error().text);
  }
}

/// Unregisters `name`, because the broker may still carry out a registration that it did not answer
/// in time. The name would then belong to this process although no object has it.
void Registrar::take_back(ClientConnection& broker, const std::string& name) {
  {
    const MutexLock lock(mutex_);
    const auto has_name = [&](const Registration& one) { return one.entry.name == name; };
    if (std::ranges::any_of(registrations_, has_name)) return;
  }
  unregister_object(broker, name);
}

bool Registrar::becomes_free(const std::string& name, TimePoint deadline) const {
  const auto holder = session::look_up(*lab_, name, deadline);
  if (holder) return sees_process(*holder) && ::kill(holder->pid, 0) != 0 && errno == ESRCH;
  const auto silent = look_up_silent(*lab_, name, deadline);
  if (!silent) return true;  // the object has left the list, or the broker was lost
  const double left =
      std::chrono::duration<double>(deadline - lab_->runtime()->clock().now()).count();
  return silent->free_in && *silent->free_in <= left;
}

void Registrar::look() {
  if (!mutex_.try_lock()) return;
  const Broker broker = broker_;
  if (broker && next_ == TimePoint::max()) {
    if (broker->lost()) want(Work::Ask);
    if (broker->may_have_ended()) want(Work::LookForNewBroker);
  }
  mutex_.unlock();
  contact_->on_tick(broker);
}

void Registrar::renew_lists() {
  const MutexLock lock(mutex_);
  bool any = false;
  for (auto& one : registrations_) {
    any = renew(one) || any;
    note_reach(one);
  }
  if (any) want(Work::Ask);
}

bool Registrar::renew(Registration& registration) const {
  const std::string& name = registration.entry.name;
  access::AllowList now = access_->named_by_program(name);
  for (auto* const names : {&now.users, &now.hosts}) keep_first_of_each(*names);
  const bool too_many = std::max(now.users.size(), now.hosts.size()) > access::most_admitted_names;
  for (auto* const names : {&now.users, &now.hosts}) {
    names->resize(std::min(names->size(), access::most_admitted_names));
  }
  AdmittedNames& admitted = registration.admitted;
  if (admitted.number != 0 && admitted.users == now.users && admitted.hosts == now.hosts)
    return false;
  admitted = {next_number(), std::move(now.users), std::move(now.hosts)};
  if (too_many) {
    log_warning("session", name +
                               " admits more users or hosts than the broker accepts: the broker " +
                               "is told the first 256 users and hosts of the lab file");
  }
  return true;
}

void Registrar::after_pause(Duration stood_still) {
  const auto& runtime = lab_->runtime();
  const MutexLock lock(mutex_);
  if (stood_still > runtime->registration_ttl()) {
    for (auto& one : registrations_) one.since = runtime->clock().since_boot();
  }
  if (!registrations_.empty()) want(Work::Ask);
}

void Registrar::note_loss(const std::string& name) {
  const MutexLock lock(mutex_);
  for (auto& one : registrations_) {
    if (one.entry.name == name) one.since = lab_->runtime()->clock().since_boot();
  }
}

void Registrar::note_confirmed(const std::string& name, TimePoint asked) {
  const MutexLock lock(mutex_);
  for (auto& one : registrations_) {
    if (one.entry.name == name) one.confirmed = asked;
  }
}

void Registrar::want(Work work) {
  wanted_ = std::max(wanted_, work);
  changed_.notify_all();
}

void Registrar::run() {
  MutexLock lock(mutex_);
  const auto due = [this] {
    mutex_.assert_held();
    return ended_ || wanted_ != Work::None;
  };
  while (!ended_) {
    if (next_ == TimePoint::max()) {
      changed_.wait(lock, due);
    } else {
      changed_.wait_until(lock, next_, due);
    }
    if (ended_) return;
    if (std::exchange(wanted_, Work::None) == Work::LookForNewBroker) {
      const TimePoint next_look = deadline_after(between_looks);
      lock.unlock();
      const bool found = has_new_broker();
      lock.lock();
      if (!found) {
        changed_.wait_until(lock, next_look, [this] {
          mutex_.assert_held();
          return ended_ || wanted_ == Work::Ask;
        });
        continue;
      }
    }
    wanted_ = Work::None;
    const auto registrations = registrations_;
    lock.unlock();
    const Duration rest = ask(registrations);
    lock.lock();
    next_ = deadline_after(rest);
  }
}

bool Registrar::has_new_broker() {
  Broker before;
  {
    const MutexLock lock(mutex_);
    before = broker_;
  }
  const auto found = find_broker(deadline_after(answer_patience));
  return found && *found != before;
}

Duration Registrar::ask(const std::vector<Registration>& registrations) {
  std::vector<std::uint64_t> questions;  // must be read before the broker is asked
  for (const auto& one : registrations)
    questions.push_back(one.object->name_confirmation().question());
  const TimePoint deadline = deadline_after(answer_patience);
  auto answers = ask_broker(registrations, deadline);
  // The broker may have ended the session of this server, for example while this process was
  // suspended. A new session may work.
  while (answers.lost && lab_->runtime()->clock().now() < deadline) {
    answers = ask_broker(registrations, deadline);
  }
  note_broker(answers.missing);

  const Duration again = pause_.after(answers.broker);
  Duration rest = answers.missing.empty() ? Duration::max() : again;
  std::string unreported;
  // The refusals in `unreported` without their request numbers, which differ at each attempt.
  std::string news;
  for (std::size_t i = 0; i < registrations.size(); ++i) {
    ObjectHost& object = *registrations[i].object;
    const auto& enlisted = answers.of_each[i];
    if (enlisted && *enlisted == Duration::zero()) {
      object.name_confirmation().held(questions[i]);
      note_confirmed(object.name(), answers.asked);
      continue;
    }
    rest = std::min(rest, enlisted ? std::min(again, *enlisted) : again);
    if (enlisted) {
      object.name_confirmation().provisional();
    } else if (enlisted.error().taken) {
      object.name_confirmation().taken(enlisted.error().by);
      note_loss(object.name());
    } else {
      object.name_confirmation().unanswered(questions[i], enlisted.error().text);
      unreported += (unreported.empty() ? "" : "; ") + object.name() +
                    " continues to run, but clients cannot find it: " + enlisted.error().text;
      news += enlisted.error().text.substr(0, enlisted.error().text.rfind(" (request "));
    }
  }
  if (!answers.missing.empty()) news.clear();  // note_broker has logged it
  if (news != std::exchange(reported_, news) && !news.empty()) log_warning("session", unreported);
  return rest;
}

Registrar::Answers Registrar::ask_broker(const std::vector<Registration>& registrations,
                                         TimePoint deadline) {
  Answers answers;
  const auto broker = find_broker(deadline);
  if (!broker) {
    answers.missing = broker.error().text;
    answers.broker = broker.error().answer;
    answers.of_each.assign(registrations.size(),
                           tl::unexpected(NotRegistered{false, {}, true, answers.missing}));
    return answers;
  }
  contact_->renew(**broker, deadline);
  std::vector<std::shared_ptr<CommandCore>> asked;
  answers.asked = lab_->runtime()->clock().since_boot();
  for (const auto& one : registrations) {
    std::optional<Duration> confirmed_ago;
    if (one.confirmed) confirmed_ago = answers.asked - *one.confirmed;
    asked.push_back(register_object(**broker, one.entry, answers.asked - one.since, one.admitted,
                                    confirmed_ago));
  }
  for (const auto& command : asked)
    answers.of_each.push_back(answer_of(**broker, *command, deadline));
  answers.lost = (*broker)->lost() || (*broker)->may_have_ended();
  return answers;
}

/// Once a broker was found, later searches use only its address: a broker at another address does
/// not know which names the first broker has assigned.
tl::expected<Registrar::Broker, NoBroker> Registrar::find_broker(TimePoint deadline) {
  std::string place;
  Broker known;
  {
    const MutexLock lock(mutex_);
    known = broker_;
    place = place_;
  }
  if (known && !known->lost() && !known->may_have_ended()) return known;
  auto found = lab_->broker(deadline);
  // `lab_` looks for a new broker at one place only, which may be another one.
  if (known && !known->lost() && (!found || (*found)->place() != place)) return known;
  if (!place.empty() && (!found || (*found)->place() != place)) {
    Detail why{};
    auto there = connect(*lab_->runtime(), place, BrokerInterface::description, deadline, &why);
    if (there) {
      found = *std::move(there);
    } else {
      // If neither `lab_` nor `place` leads to a broker, the error of `lab_` says what to do.
      const auto answer = why == Detail::Refused ? BrokerAnswer::Refused
                          : found                ? BrokerAnswer::Other
                                                 : found.error().answer;
      found = tl::unexpected(
          NoBroker{found ? std::move(there.error()) : std::move(found.error().text), answer});
    }
  }
  if (!found) return found;
  const MutexLock lock(mutex_);
  if (ended_) return tl::unexpected(NoBroker{"the server has ended"});
  place_ = (*found)->place();
  broker_ = *found;
  return found;
}

void Registrar::end() {
  {
    const MutexLock lock(mutex_);
    if (ended_) return;
    ended_ = true;
  }
  changed_.notify_all();
  thread_.join();  // the thread may just have registered the objects with another broker
  Broker broker;
  std::vector<Registration> registrations;
  {
    const MutexLock lock(mutex_);
    broker = std::move(broker_);
    registrations.swap(registrations_);
  }
  for (const auto& one : registrations) {
    if (broker && !broker->lost()) unregister_object(*broker, one.entry.name);
  }
}

}  // namespace gecos::session
