// Commands a Workbench without pause, whatever dies, and notes each command's issue, its states and
// its end. SIGTERM: issues no more, waits for what is open, looks at all again, ends. Told where to
// note that, it serves the Workbench itself, for a client in the same process.

#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <random>
#include <stdexcept>
#include <thread>

#include "another_try.hpp"
#include "gecos/gecos.hpp"
#include "record.hpp"
#include "setting.hpp"
#include "stress/workbench_client.hpp"
#include "workbench.hpp"

namespace {

using namespace std::chrono_literals;

std::atomic<bool> told_to_end{false};

/// A command whatever it gives.
struct Issued {
  std::uint64_t number = 0;
  std::shared_ptr<gecos::session::CommandCore> core;
  std::function<std::string()> result;  ///< waits; "-" when there is none
};

std::string seen(const gecos::session::CommandCore& core) {
  const gecos::Detail detail = core.progress().detail;
  return std::string(to_string(gecos::project(detail))) + " " + std::string(to_string(detail));
}

/// How long a motion lasts that is not cancelled: longer than it may run on after its client's
/// death.
constexpr double motion_s = 5;

class Client {
 public:
  explicit Client(const stress::Setting& setting)
      : setting_(setting),
        record_(setting.text("record")),
        random_(static_cast<std::uint64_t>(setting.number("seed"))),
        next_number_((static_cast<std::uint64_t>(setting.number("number")) << 32) + 1),
        lab_(setting.lab()) {
    record_.note("client " + std::to_string(getpid()));
    for (int at = 0; at < 2; ++at) waiters_.emplace_back([this] { follow(); });
  }

  void run() {
    while (!told_to_end) {
      if (!connected_ && !connect()) continue;
      act();
      rest();
    }
  }

  /// Waits until all have ended; then none may have changed.
  void end() {
    {
      std::unique_lock lock(mutex_);
      room_.wait(lock, [this] { return open_ == 0; });
      over_ = true;
      work_.notify_all();
    }
    for (auto& waiter : waiters_) waiter.join();
    look_again();
    record_.note("done");
  }

 private:
  double up_to(double most) { return std::uniform_real_distribution<>(0, most)(random_); }
  bool happens(double rate) { return up_to(1) < rate; }

  bool connect() {
    lease_.reset();
    push_.reset();
    bench_ = {};
    auto created =
        lab_.create<stress::Workbench>("BENCH", {.medium = setting_.medium(), .patience = 500ms});
    if (!created) {
      stress::rest_before_another_try();
      return false;
    }
    const auto about = gecos::describe(*created).get();
    if (!about) return false;
    bench_ = *created;
    connected_ = true;
    ++session_;
    record_.note("open " + std::to_string(session_) + " " + std::to_string(about->pid));
    if (auto writer = bench_.push(gecos::writer)) push_.emplace(*std::move(writer));
    return acquire();
  }

  bool acquire() {
    release();
    auto lease = gecos::actor(bench_, "stress");
    if (lease) {
      lease_.emplace(std::move(*lease));
      note_status("granted", "ACTOR");
    } else if (lease.error().failure.state() == gecos::State::ConnectionFailed) {
      connected_ = false;
    }
    return connected_;
  }

  void release() {
    if (!lease_) return;
    lease_.reset();
    note_status("released");
  }

  void note_status(const char* event, const std::string& more = {}) {
    record_.note(event + (" " + std::to_string(session_)) + (more.empty() ? "" : " " + more));
  }

  /// Returns whether the server has done it. A client that pretends does not ask.
  template <class Ask>
  bool ask(const std::string& what, Ask ask) {
    note_status("asks", what);
    if (what != setting_.text("pretends") && !ask().get()) return false;
    note_status("did", what);
    return true;
  }

  /// Moves alone for a while. A client that is killed meanwhile leaves a motion that runs.
  void take_over() {
    if (!ask("take", [this] { return gecos::take_over(bench_); })) return;
    const auto motion = file(motion_s);
    const auto lasts = std::chrono::duration<double>(up_to(0.2));
    motion.wait_for(std::chrono::duration_cast<gecos::Duration>(lasts));
    motion.cancel();
    motion.wait();
    tap();
    await_all();
    ask("give", [this] { return gecos::give_back(bench_); });
  }

  /// Stops the others, is master if none of them was faster, and then an actor again.
  void be_master() {
    if (!ask("stop", [this] { return gecos::stop(bench_); })) return;
    std::optional<gecos::Lease> master;
    if (setting_.text("pretends") != "master") {
      auto granted = gecos::master(bench_);
      if (!granted) return;
      master.emplace(std::move(*granted));
    }
    note_status("granted", "MASTER");
    command_for_a_while();
    master.reset();
    release();
    tap();  // is refused
    acquire();
  }

  /// Stops the others, has a status with a password of its own if none of them was faster, and is
  /// then an actor as the others again.
  void use_another_password() {
    if (!ask("stop", [this] { return gecos::stop(bench_); })) return;
    if (setting_.text("pretends") != "password") {
      release();
      auto granted = gecos::actor(bench_, "client " + std::to_string(::getpid()));
      if (granted) lease_.emplace(std::move(*granted));
    }
    if (lease_) {
      note_status("granted", "ACTOR own");
      command_for_a_while();
    }
    acquire();
  }

  void command_for_a_while() {
    for (int left = 4; left > 0; --left) issue();
    static_cast<void>(file(up_to(0.05)));
    tap();
    await_all();
  }

  void change_status() {
    const double which = up_to(1);
    const std::string& only = setting_.text("change");
    if (only.empty() ? which < 0.5 : only == "take") {
      take_over();
    } else if (only.empty() ? which < 0.7 : only == "master") {
      be_master();
    } else if (only.empty() ? which < 0.9 : only == "password") {
      use_another_password();
    } else {
      ask("break", [this] { return gecos::break_status(bench_, "a test of the judge"); });
    }
  }

  void act() {
    const bool burst = happens(0.01);  // beyond what one client may queue
    for (int left = burst ? 100 : 1 + static_cast<int>(random_() % 8); left > 0; --left) issue();
    if (happens(0.05)) cancel_one();
    if (happens(0.5)) send();
    if (happens(setting_.text("change").empty() ? 0.01 : 0.2)) change_status();
    if (happens(0.01)) {
      ask("stop", [this] { return gecos::stop(bench_); });
      acquire();
    } else if (status_lost_.exchange(false) || happens(0.01)) {
      acquire();
    }
    if (session_lost_.exchange(false)) connected_ = false;
  }

  void send() {
    const std::uint64_t number = next_number_++;
    record_.note("send " + std::to_string(number) + " " + std::to_string(session_));
    if (push_) static_cast<void>(push_->send(number));
  }

  void tap() {
    const std::uint64_t number = next_number_++;
    const auto salt = static_cast<std::int64_t>(random_());
    note_issue(number, "tap", stress::answer(number, salt));
    follow(number, bench_.tap(number, salt));
  }

  gecos::Command<std::int64_t> file(double seconds) {
    const std::uint64_t number = next_number_++;
    const auto salt = static_cast<std::int64_t>(random_());
    note_issue(number, "file", stress::answer(number, salt));
    auto command = bench_.file(number, salt, seconds);
    follow(number, command);
    return command;
  }

  void issue() {
    const double which = up_to(1);
    if (which < 0.45) return tap();
    if (which < 0.6) return static_cast<void>(file(1e-3 * static_cast<double>(random_() % 5)));
    const std::uint64_t number = next_number_++;
    const auto salt = static_cast<std::int64_t>(random_());
    if (which < 0.75) {
      note_issue(number, "gauge", stress::answer(number, salt));
      follow(number, bench_.gauge(number, salt));
    } else if (which < 0.85) {
      note_issue(number, "look", stress::answer(number, salt));
      follow(number, bench_.look(number, salt));
    } else {
      std::vector<std::uint8_t> load(happens(0.1) ? random_() % 40'000 : random_() % 200);
      for (auto& byte : load) byte = static_cast<std::uint8_t>(random_());
      note_issue(number, "weigh", stress::answer(number, load));
      follow(number, bench_.weigh(number, load));
    }
  }

  void note_issue(std::uint64_t number, const char* operation, std::int64_t wanted) {
    record_.note("issue " + std::to_string(number) + " " + operation + " " +
                 std::to_string(session_) + " " + std::to_string(wanted));
  }

  static std::string shown(std::uint64_t /*number*/, std::int64_t result) {
    return std::to_string(result);
  }
  static std::string shown(std::uint64_t number, const std::vector<std::uint8_t>& result) {
    return std::to_string(stress::answer(number, result));
  }

  template <class T>
  void follow(std::uint64_t number, gecos::Command<T> command) {
    Issued issued{number, command.core(), [number, command] {
                    const auto result = command.get();
                    return result ? shown(number, *result) : std::string("-");
                  }};
    const std::lock_guard lock(mutex_);
    ++open_;
    followed_.push_back(std::move(issued));
    work_.notify_one();
  }

  /// On a thread of its own: waits without time-out for one after another.
  void follow() {
    for (;;) {
      Issued issued;
      {
        std::unique_lock lock(mutex_);
        work_.wait(lock, [this] { return over_ || !followed_.empty(); });
        if (followed_.empty()) return;
        issued = std::move(followed_.front());
        followed_.pop_front();
      }
      if (issued.number % 16 == 0) record_.note(about("see ", issued));
      const std::string result = issued.result();
      record_.note(about("end ", issued) + " " + result);
      learn(*issued.core);
      const std::lock_guard lock(mutex_);
      ended_.push_back(std::move(issued));
      if (ended_.size() > 256) ended_.pop_front();
      --open_;
      room_.notify_one();
    }
  }

  static std::string about(const char* what, const Issued& issued) {
    return what + std::to_string(issued.number) + " " + seen(*issued.core);
  }

  void learn(const gecos::session::CommandCore& core) {
    switch (core.progress().detail) {
      case gecos::Detail::LeaseLost:
      case gecos::Detail::Denied:
      case gecos::Detail::Stopped:
        status_lost_ = true;
        break;
      case gecos::Detail::NoServer:
      case gecos::Detail::NotStarted:
      case gecos::Detail::ServerCrashed:
      case gecos::Detail::OutcomeUnknown:
        session_lost_ = true;
        break;
      default:
        break;
    }
  }

  void cancel_one() {
    const std::lock_guard lock(mutex_);
    if (!followed_.empty()) followed_[random_() % followed_.size()].core->cancel();
  }

  void look_again() {
    const std::lock_guard lock(mutex_);
    for (const auto& issued : ended_) record_.note(about("see ", issued));
  }

  void await_all() {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [this] { return open_ == 0; });
  }

  /// Until there is room for more; every other time a random moment longer, for calls after silence
  /// too.
  void rest() {
    {
      std::unique_lock lock(mutex_);
      room_.wait(lock, [this] { return open_ < 48; });
    }
    if (happens(0.5)) {
      const double rest_ms = up_to(setting_.number("rest_ms"));
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(rest_ms));
    }
    if (happens(0.1)) look_again();
  }

  const stress::Setting& setting_;
  const stress::Record record_;
  std::mt19937_64 random_;
  std::uint64_t next_number_;
  gecos::Lab lab_;
  stress::Workbench bench_;
  std::optional<gecos::Lease> lease_;
  std::optional<gecos::Writer<std::uint64_t>> push_;
  bool connected_ = false;
  int session_ = 0;
  std::atomic<bool> status_lost_{false};   // publishes nothing but itself
  std::atomic<bool> session_lost_{false};  // publishes nothing but itself

  std::mutex mutex_;  // guards what follows
  std::condition_variable work_;
  std::condition_variable room_;
  std::deque<Issued> followed_;
  std::deque<Issued> ended_;
  int open_ = 0;
  bool over_ = false;
  std::vector<std::thread> waiters_;
};

/// The server of this process.
class ServedHere {
 public:
  explicit ServedHere(const stress::Setting& setting) : record_(setting.text("serve")) {
    const auto added = server_.add("BENCH", workbench_, stress::over(setting.medium()));
    if (!added) throw std::runtime_error(added.error().text);
    record_.note("serve " + std::to_string(getpid()));
  }

 private:
  const stress::Record record_;
  gecos::Lab lab_;
  stress::RecordedBench workbench_{record_};
  gecos::Server server_{lab_};
};

}  // namespace

int main(int count, char** words) {
  const stress::Setting setting(count, words,
                                {{"number", "1"},
                                 {"record", ""},
                                 {"serve", ""},
                                 {"medium", "shm"},
                                 {"faults", ""},
                                 {"rest_ms", "10"},
                                 {"pretends", ""},
                                 {"change", ""},
                                 {"seed", "1"}});
  std::signal(SIGTERM, [](int) { told_to_end = true; });
  const stress::Balance balance;
  {
    std::optional<ServedHere> server;
    if (!setting.text("serve").empty()) server.emplace(setting);
    std::puts("ready");
    std::fflush(stdout);
    Client client(setting);
    client.run();
    client.end();
  }
  balance.close();
}
