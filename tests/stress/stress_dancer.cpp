// Serves DANCER, and prints a line for everything that a client makes it do.

#include <atomic>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "feeder_server.hpp"
#include "gecos/gecos.hpp"

namespace {

using namespace std::chrono_literals;

void tell(const std::string& what) {
  std::printf("did %s\n", what.c_str());
  std::fflush(stdout);
}

std::string in_words(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

class CountingDancer final : public feeding::DancerServant {
 public:
  ~CountingDancer() override {
    ends_ = true;
    control_.join();
  }

 protected:
  /// Ends by itself once it has taken a correction whose count is negative.
  gecos::Result<double> follow(gecos::Execution<feeding::Step>& run) override {
    tell("follow");
    const auto feeding = alter().feeds(run);
    double total = 0;
    run.progress(0, feeding::Step{});
    while (!run.wait_interrupted(1ms)) {
      while (const auto step = alter().next()) {
        tell("alter " + std::to_string(step->value.count));
        if (step->value.count < 0) return total;
        total += step->value.x;
        run.progress(0, step->value);
      }
    }
    return tl::unexpected(gecos::Fault::interrupted());
  }
  gecos::Result<std::vector<double>> speeds() override {
    tell("speeds");
    return {};
  }
  gecos::Result<std::vector<std::string>> remarks() override {
    tell("remarks");
    return {};
  }
  gecos::Result<std::vector<std::int32_t>> steps() override {
    tell("steps");
    return {};
  }
  gecos::Result<std::string> told(const std::string& /*stream*/) override {
    tell("told");
    return {};
  }
  gecos::Result<std::int32_t> feet() override {
    tell("feet");
    return 2;
  }

 private:
  /// The loop of a device that is moved by samples of a speed.
  void control() {
    for (; !ends_; std::this_thread::sleep_for(2ms)) {
      while (const auto sample = speed().next()) tell("speed " + in_words(sample->value));
      while (const auto sample = remark().next()) tell("remark " + sample->value.text);
    }
  }

  std::atomic<bool> ends_{false};  // publishes nothing but itself
  std::thread control_{[this] { control(); }};
};

}  // namespace

int main() {
  gecos::Lab lab;
  CountingDancer dancer;
  return gecos::serve(lab,
                      {{"DANCER", dancer, {.simulated = true, .on_stop = [] { tell("stop"); }}}});
}
