// A connection that loses, repeats, reorders and damages packets, both ways: every call over it
// ends, runs at most once, in order, with undamaged arguments and results.
#include <gtest/gtest.h>

#include <cstdlib>
#include <deque>
#include <mutex>
#include <random>
#include <thread>

#include "../cpp/media/kind_names.hpp"
#include "gecos/binding.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"
#include "gecos/media/testing/faulty.hpp"
#include "record.hpp"
#include "stress/workbench_client.hpp"
#include "stress/workbench_server.hpp"

namespace {

using gecos::Detail;
using gecos::media::Kind;

const gecos::SystemClock real_clock;

#ifdef __SANITIZE_THREAD__  // each takes a hundred times as long: what is late is sent again
constexpr std::uint64_t usual_calls = 2'000;
#else
constexpr std::uint64_t usual_calls = 10'000;
#endif

std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
  const char* const text = std::getenv(name);
  return text != nullptr && *text != '\0' ? std::stoull(text) : otherwise;
}

/// Each program of the test has its own faulty connection, all with the same faults. Even on a slow
/// machine no peer counts as lost: a call that ends with anything but DONE is a defect.
gecos::Lab bad_line(std::uint64_t seed) {
  const gecos::media::Faults faults{
      .seed = seed, .loss = 0.1, .duplication = 0.1, .corruption = 0.01, .reordering = 0.3};
  gecos::LabOptions options;
  options.grace = options.lease_ttl = std::chrono::seconds(20);
  const auto wrap = [faults](std::unique_ptr<gecos::media::Medium> inner) {
    return gecos::media::make_faulty(std::move(inner), faults, real_clock);
  };
  return gecos::session::LabAccess::with_media(options, wrap);
}

/// Counts the runs of each command, and the commands that came reordered or damaged.
class Counting : public stress::WorkbenchServant {
 public:
  /// Each of `clients` has `share` numbers; the clients' ranges follow each other.
  Counting(std::uint64_t clients, std::uint64_t share)
      : share_(share), runs_(clients * share), last_(clients) {}

  int runs(std::uint64_t command) const {
    const std::lock_guard lock(mutex_);
    return runs_[command];
  }
  int out_of_order() const {
    const std::lock_guard lock(mutex_);
    return out_of_order_;
  }

 private:
  gecos::Result<std::int64_t> tap(std::uint64_t command, std::int64_t salt) override {
    ran_in_order(command);
    return stress::answer(command, salt);
  }
  gecos::Result<std::int64_t> file(std::uint64_t command, std::int64_t salt, double,
                                   gecos::Execution<>&) override {
    ran_in_order(command);
    return stress::answer(command, salt);
  }
  gecos::Result<std::int64_t> gauge(std::uint64_t command, std::int64_t salt) override {
    ran(command);
    return stress::answer(command, salt);
  }
  gecos::Result<std::vector<std::uint8_t>> weigh(std::uint64_t command,
                                                 const std::vector<std::uint8_t>& load) override {
    ran(command);
    return load;
  }

  gecos::Result<std::int64_t> look(std::uint64_t command, std::int64_t salt) override {
    ran(command);
    return stress::answer(command, salt);
  }

  void ran(std::uint64_t command) {
    const std::lock_guard lock(mutex_);
    ++runs_.at(command);
  }
  void ran_in_order(std::uint64_t command) {
    const std::lock_guard lock(mutex_);
    ++runs_.at(command);
    std::uint64_t& last = last_.at(command / share_);
    out_of_order_ += command < last ? 1 : 0;
    last = command;
  }

  const std::uint64_t share_;
  mutable std::mutex mutex_;
  std::vector<int> runs_;
  std::vector<std::uint64_t> last_;
  int out_of_order_ = 0;
};

/// An open call, and the comparison of its result with the expected one; "" if it is right.
struct Open {
  std::uint64_t number;
  std::function<std::string()> wrong;
  std::function<Detail()> detail;
};

template <class T>
Open open(std::uint64_t number, gecos::Command<T> command, T wanted) {
  return {number,
          [command, wanted]() -> std::string {
            const auto got = command.get();
            if (!got) return got.error().text;
            return *got == wanted ? "" : "another result than was right";
          },
          [command] { return command.progress().detail; }};
}

Open issue(const stress::Workbench& bench, std::uint64_t number, std::mt19937_64& random) {
  const auto salt = static_cast<std::int64_t>(random());
  switch (random() % 8) {
    case 0:
      return open(number, bench.file(number, salt, 0), stress::answer(number, salt));
    case 1:
      return open(number, bench.gauge(number, salt), stress::answer(number, salt));
    case 4:
      return open(number, bench.look(number, salt), stress::answer(number, salt));
    case 2:
    case 3: {
      std::vector<std::uint8_t> load(random() % 2000);
      for (auto& byte : load) byte = static_cast<std::uint8_t>(random());
      return open(number, bench.weigh(number, load), load);
    }
    default:
      return open(number, bench.tap(number, salt), stress::answer(number, salt));
  }
}

/// One client's share of the calls: `count` of them from `first` on, some of them at a time.
class Caller {
 public:
  Caller(const Counting& counting, std::uint64_t seed)
      : counting_(counting), random_(seed), lab_(bad_line(seed)) {}

  void connect() {
    auto created = lab_.create<stress::Workbench>("BENCH", {.patience = std::chrono::seconds(10)});
    ASSERT_TRUE(created) << created.error();
    bench_ = *created;
    auto lease = gecos::actor(bench_, "stress");
    ASSERT_TRUE(lease) << lease.error();
    lease_.emplace(std::move(*lease));
  }

  void run(std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t number = first; number < first + count && !failed(); ++number) {
      open_.push_back(issue(bench_, number, random_));
      if (open_.size() == most_open) finish();
    }
    while (!open_.empty() && !failed()) finish();
  }

 private:
  static constexpr std::size_t most_open = 12;  // of 16 clients that is less than the queue holds

  static bool failed() { return ::testing::Test::HasFailure(); }
  void finish() {
    const Open first = std::move(open_.front());
    open_.pop_front();
    const std::string wrong = first.wrong();
    EXPECT_EQ(wrong, "") << "command " << first.number << ", " << first.detail();
    EXPECT_EQ(counting_.runs(first.number), 1) << "command " << first.number;
  }

  const Counting& counting_;
  std::mt19937_64 random_;
  gecos::Lab lab_;
  stress::Workbench bench_;
  std::optional<gecos::Lease> lease_;
  std::deque<Open> open_;
};

class FaultyLine : public ::testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Over, FaultyLine, ::testing::Values(Kind::Inproc, Kind::Lcm),
                         gecos::media::name_of);

TEST_P(FaultyLine, CarriesEveryCallOnceInOrderAndUndamaged) {
  constexpr std::uint64_t clients = 16;
  const std::uint64_t share = from_environment("STRESS_CALLS", usual_calls) / clients;
  const std::uint64_t seed = from_environment("STRESS_SEED", std::random_device()());
  std::cout << share * clients << " calls, STRESS_SEED=" << seed << std::endl;

  gecos::Lab broker_lab(bad_line(seed));
  gecos::broker::Broker broker;
  gecos::Server broker_server(broker_lab);
  ASSERT_TRUE(broker.serve(broker_server, {Kind::Inproc}));
  gecos::Lab server_lab(bad_line(seed + 1));
  Counting counting(clients, share);
  gecos::Server server(server_lab);
  gecos::ObjectOptions options;
  options.simulated = true;
  options.media = {GetParam()};
  const auto added = server.add("BENCH", counting, options);
  ASSERT_TRUE(added) << added.error().text;
  {
    std::deque<Caller> callers;
    for (std::uint64_t at = 0; at < clients; ++at) {
      ASSERT_NO_FATAL_FAILURE(callers.emplace_back(counting, seed + 2 + at).connect());
    }
    std::vector<std::thread> threads;
    for (std::uint64_t at = 0; at < clients; ++at) {
      threads.emplace_back([&, at] { callers[at].run(at * share, share); });
    }
    for (auto& thread : threads) thread.join();
  }
  EXPECT_EQ(counting.out_of_order(), 0) << "commands started before those issued before them";
  if (HasFailure()) return;  // the rest was not issued
  for (std::uint64_t number = 0; number < clients * share; ++number) {
    ASSERT_EQ(counting.runs(number), 1) << "command " << number << " did not run once";
  }
}

}  // namespace
