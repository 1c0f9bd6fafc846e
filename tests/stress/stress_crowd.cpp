// Many objects, or many clients of them, in one process; tests/stress/crowd.py starts some of both.
// `serve=A,B` serves these objects until SIGTERM. `reach=A,B clients=20` connects to them in turn
// with so many proxies, then does what each line of its input says: "call <n>" makes n calls
// through the first proxy and prints their median.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "gecos/gecos.hpp"
#include "gecos/session/process/termination_signals.hpp"
#include "setting.hpp"
#include "stress/workbench_client.hpp"
#include "stress/workbench_server.hpp"
#include "workbench.hpp"

namespace {

using namespace std::chrono_literals;

/// Answers everything at once.
class QuickBench final : public stress::WorkbenchServant {
  gecos::Result<std::int64_t> tap(std::uint64_t /*command*/, std::int64_t salt) override {
    return salt;
  }
  gecos::Result<std::int64_t> file(std::uint64_t /*command*/, std::int64_t salt, double /*seconds*/,
                                   gecos::Execution<>& /*run*/) override {
    return salt;
  }
  gecos::Result<std::vector<std::uint8_t>> weigh(std::uint64_t /*command*/,
                                                 const std::vector<std::uint8_t>& load) override {
    return load;
  }
  gecos::Result<std::int64_t> look(std::uint64_t /*command*/, std::int64_t salt) override {
    return salt;
  }
  gecos::Result<std::int64_t> gauge(std::uint64_t /*command*/, std::int64_t salt) override {
    return salt;
  }
};

std::vector<std::string> names_in(const std::string& list) {
  std::vector<std::string> names;
  std::istringstream from(list);
  for (std::string name; std::getline(from, name, ',');) names.push_back(name);
  return names;
}

template <class What>
int fail(const What& what) {
  std::cerr << what << std::endl;
  return 1;
}

int serve(const stress::Setting& setting) {
  const auto names = names_in(setting.text("serve"));
  std::vector<QuickBench> benches(names.size());
  gecos::Lab lab;
  gecos::Server server(lab);
  for (std::size_t at = 0; at < names.size(); ++at) {
    const auto added = server.add(names[at], benches[at], stress::over(setting.medium()));
    if (!added) return fail(added.error().text);
  }
  const gecos::session::TerminationSignals from_here_on;  // also before run() takes the signals
  std::puts("ready");
  std::fflush(stdout);
  server.run();
  return 0;
}

/// Returns the median of the durations of `count` calls in µs; nullopt when a call fails.
std::optional<double> median_of_calls(const stress::Workbench& bench, std::size_t count) {
  std::vector<std::chrono::steady_clock::duration> took;
  for (std::size_t call = 0; call < count; ++call) {
    const auto began = std::chrono::steady_clock::now();
    if (!bench.look(call, 1).get()) return std::nullopt;
    took.push_back(std::chrono::steady_clock::now() - began);
  }
  const auto middle = took.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::ranges::nth_element(took, middle);
  return std::chrono::duration<double, std::micro>(*middle).count();
}

int reach(const stress::Setting& setting) {
  gecos::Lab lab;
  const auto names = names_in(setting.text("reach"));
  const auto clients = static_cast<std::size_t>(setting.number("clients"));
  std::vector<stress::Workbench> benches;
  for (std::size_t at = 0; at < clients; ++at) {
    auto created = lab.create<stress::Workbench>(
        names[at % names.size()], {.medium = setting.medium(), .patience = 10s, .wait = 10s});
    if (!created) return fail(created.error());
    benches.push_back(std::move(*created));
  }
  std::puts("ready");
  std::fflush(stdout);
  for (std::string word; std::cin >> word;) {
    std::size_t count = 0;
    if (word != "call" || !(std::cin >> count) || count == 0) return fail("not known: " + word);
    const auto median = median_of_calls(benches.front(), count);
    if (!median) return fail("a call failed");
    std::printf("median %.3f\n", *median);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int count, char** words) {
  const stress::Setting setting(
      count, words, {{"serve", ""}, {"reach", ""}, {"clients", "1"}, {"medium", "shm"}});
  return setting.text("serve").empty() ? reach(setting) : serve(setting);
}
