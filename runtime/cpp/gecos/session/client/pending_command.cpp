#include "gecos/session/client/pending_command.hpp"

#include <algorithm>
#include <set>
#include <sstream>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/per_process.hpp"
#include "gecos/binding.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/process/callbacks.hpp"
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {
namespace {

/// The failures that were logged because nobody observed them.
struct Reported {
  Mutex mutex;
  std::set<std::pair<std::string, Detail>> failures GECOS_GUARDED_BY(mutex);
};

/// Returns true only for the first failure of the operation `about` that has the detail `detail`,
/// so that a failure in a loop does not fill the disk with log lines.
bool first_of_its_kind(const std::string& about, Detail detail) {
  static constinit PerProcess<Reported> of_processes;
  Reported& reported = of_processes.get();
  const MutexLock lock(reported.mutex);
  return reported.failures.emplace(about, detail).second;
}

void tell_unasked(const std::string& about, const Failure& failure) {
  if (!first_of_its_kind(about, failure.detail)) return;
  std::ostringstream line;
  line << (about.empty() ? "a command" : about)
       << " failed, and nobody observed the failure: " << failure
       << ". Keep the command and wait() for it, or detach() it; later failures of this kind are "
          "not logged";
  log_warning("command", std::move(line).str());
}

}  // namespace

PendingCommand::PendingCommand(Failure failure)
    : detail_(failure.detail), failure_(std::move(failure)) {
  if (!log_enabled(LogLevel::Info)) return;
  std::ostringstream line;
  line << "a command was not sent: " << failure_;
  log_info("client", std::move(line).str());
}

PendingCommand::~PendingCommand() {
  const Detail detail = detail_.load(std::memory_order_relaxed);
  if (observed() || project(detail) == State::Running || detail == Detail::Done) return;
  tell_unasked(about_, failure_);
}

std::shared_ptr<ClientConnection> PendingCommand::session() const {
  const MutexLock lock(mutex_);
  return session_;
}

CommandId PendingCommand::id() const {
  const MutexLock lock(mutex_);
  return {incarnation, session_id, counter};
}

std::string PendingCommand::about() const {
  const MutexLock lock(mutex_);
  return session_ == nullptr ? about_ : name_in(*session_);
}

std::string PendingCommand::name_in(const ClientConnection& session) const {
  return session.object_name() + "." + std::string(operation_);
}

void PendingCommand::note_look(Detail seen) const {
  if (!chain.failures || seen == Detail::Done || project(seen) == State::Running) return;
  if (looked_.exchange(true, std::memory_order_relaxed)) return;
  const auto place =
      chain.because_of == 0 ? chain.place : SeenFailures::Place{true, chain.because_of};
  chain.failures->knows(place, ChainReport::Known::Failure);
}

void PendingCommand::ignore_outcome() {
  observe();
  if (!chain.failures) return;
  const bool ended_well = terminal() && detail_.load(std::memory_order_relaxed) == Detail::Done;
  const bool was_left_out = terminal() && chain.because_of != 0;
  if (!ended_well && !was_left_out) {
    chain.failures->knows(chain.place, ChainReport::Known::Detached);
  }
}

Progress PendingCommand::progress() const {
  if (terminal()) return {detail_.load(std::memory_order_relaxed), 0, fraction_};
  bool unreachable = false;
  if (const auto session = this->session()) {
    session->reader().poll_once();
    unreachable = session->unreachable();
  }
  const MutexLock lock(mutex_);
  const Detail detail = detail_.load(std::memory_order_relaxed);
  const bool running = project(detail) == State::Running;
  return {running && (unreachable || awaits_failover()) ? Detail::Unreachable : detail, position_,
          fraction_};
}

Bytes PendingCommand::feedback() const {
  if (const auto session = this->session()) session->reader().poll_once();
  const MutexLock lock(mutex_);
  return feedback_;
}

bool PendingCommand::wait_until(TimePoint deadline) {
  observe();
  if (terminal()) return true;
  std::optional<WaitsHere> endless;
  if (deadline == TimePoint::max()) endless.emplace(*this);
  if (again) return wait_in_any_session(deadline);
  const auto session = this->session();
  if (!session) return true;
  return session->reader().wait(
      this, [this] { return terminal(); }, deadline);
}

void PendingCommand::cancel() {
  if (chain.failures && !terminal()) {
    chain.failures->knows(chain.place, ChainReport::Known::Canceled);
  }
  if (again) return cancel_in_any_session();
  if (const auto session = this->session()) session->calls().cancel(*this, counter);
}

int PendingCommand::descriptor() {
  const MutexLock lock(mutex_);
  if (!exported_) {
    exported_ = std::make_unique<EventFd>();
    if (terminal()) exported_->notify();
    watch_end();
  }
  return exported_->descriptor();
}

void PendingCommand::when_ended(std::function<void()> then) {
  {
    const MutexLock lock(mutex_);
    if (!terminal()) {
      callbacks_.push_back(std::move(then));
      return watch_end();
    }
  }
  run_callback(then);
}

void PendingCommand::watch_end() {
  if (!session_ || std::exchange(watched_, true)) return;
  session_->reader().add_watcher();
}

void PendingCommand::report(Detail detail, const ProgressBody& body) {
  const MutexLock lock(mutex_);
  if (terminal()) return;
  detail_.store(detail, std::memory_order_relaxed);
  position_ = body.position;
  fraction_ = body.fraction > 0 ? std::min(body.fraction, 1.0) : 0;  // NaN counts as 0
  if (!body.feedback.empty()) feedback_ = body.feedback;
}

void PendingCommand::log_end(const ClientConnection& in, Detail detail) const {
  std::ostringstream line;
  line << name_in(in) << " ended ";
  if (detail == Detail::Done) {
    line << "FINISHED/DONE";
  } else {
    line << failure_;
  }
  log(actor_ ? LogLevel::Info : LogLevel::Debug, "client", std::move(line).str());
}

/// Publishes the terminal state last, because a waiting thread may then destroy its reference to
/// the command at once. The caller's reference keeps the command alive during this function.
template <class Publish>
void PendingCommand::end(Detail detail, Publish publish) {
  std::shared_ptr<ClientConnection> released;
  const MutexLock lock(mutex_);
  if (terminal()) return;
  publish();
  position_ = 0;
  released = std::move(session_);
  if (released && log_enabled(actor_ ? LogLevel::Info : LogLevel::Debug))
    log_end(*released, detail);
  if (watched_) released->reader().remove_watcher();
  if (exported_) exported_->notify();
  if (again) again->attached.notify_all();
  for (auto& callback : callbacks_) released->runtime().callbacks().post(std::move(callback));
  callbacks_.clear();
  detail_.store(detail, std::memory_order_seq_cst);
}

void PendingCommand::finish(ByteView result) {
  end(Detail::Done, [&] {
    result_.assign(result);
    fraction_ = 1;
  });
}

void PendingCommand::fail(Failure failure) {
  // Even if the last session proves that the command did not start in that session, the command may
  // have started in an earlier session.
  if (again && again->may_have_started && failure.state() == State::ConnectionFailed) {
    failure.detail = Detail::OutcomeUnknown;
  }
  const Detail detail = failure.detail;
  end(detail, [&] {
    mutex_.assert_held();
    if (!operation_.empty() && !observed()) {
      about_ = name_in(*session_);
    }
    failure_ = std::move(failure);
  });
}

// The functions below move a command to another session.

void PendingCommand::attach(const std::shared_ptr<ClientConnection>& session, const CommandId& id,
                            std::uint64_t as) {
  std::shared_ptr<ClientConnection> before;
  const MutexLock lock(mutex_);
  incarnation = id.incarnation;
  session_id = id.session;
  counter = id.counter;
  sent_as = as;
  retry = {};
  ++again->sessions;
  if (terminal()) return;
  before = std::exchange(session_, session);
  detail_.store(Detail::Sent, std::memory_order_relaxed);
  position_ = 0;
  fraction_ = 0;
  feedback_.clear();
  home_.store(session.get(), std::memory_order_release);
  again->attached.notify_all();
  if (before == session || !watched_) return;
  if (before) before->reader().remove_watcher();
  session->reader().add_watcher();
}

bool PendingCommand::wait_in_any_session(TimePoint deadline) {
  for (;;) {
    std::shared_ptr<ClientConnection> session;
    {
      MutexLock lock(mutex_);
      const auto settled = [this] { return terminal() || !awaits_failover(); };
      if (deadline == TimePoint::max()) {
        again->attached.wait(lock, settled);
      } else if (!again->attached.wait_until(lock, deadline, settled)) {
        return false;
      }
      if (terminal()) return true;
      session = session_;
    }
    const auto over = [&] { return terminal() || home_.load() != session.get(); };
    if (!session->reader().wait(this, over, deadline)) return false;
  }
}

void PendingCommand::cancel_in_any_session() {
  for (;;) {
    std::shared_ptr<ClientConnection> session;
    std::uint64_t here = 0;
    bool at_sea = false;
    {
      const MutexLock lock(mutex_);
      if (terminal()) return;
      session = session_;
      here = counter;
      at_sea = awaits_failover();
    }
    if (at_sea) {
      return fail({Detail::Canceled,
                   "canceled while its server was gone; the command is not sent again",
                   {},
                   {}});
    }
    if (session->calls().cancel(*this, here) || home_.load() == session.get()) return;
  }
}

}  // namespace gecos::session
