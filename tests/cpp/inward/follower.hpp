// Serves tests/idl/inward/feeder.gidl: what reaches a servant can be asked for.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "feeder_server.hpp"
#include "gecos/gecos.hpp"
#include "in_words.hpp"

namespace feeding {

class PlainFollower final : public DancerServant {
 public:
  PlainFollower() = default;

 protected:
  /// Ends by itself once it has taken a correction whose count is negative.
  gecos::Result<double> follow(gecos::Execution<Step>& run) override {
    const auto feeding = alter().feeds(run);
    double sum = 0;
    run.progress(0, Step{});
    while (!run.wait_interrupted(std::chrono::milliseconds(1))) {
      while (const auto step = alter().next()) {
        if (step->value.count < 0) return sum;
        sum += step->value.x;
        run.progress(0, step->value);
      }
    }
    return tl::unexpected(gecos::Fault::interrupted());
  }
  gecos::Result<std::vector<double>> speeds() override {
    std::vector<double> values;
    while (const auto sample = speed().next()) values.push_back(sample->value);
    return values;
  }
  gecos::Result<std::vector<std::string>> remarks() override {
    std::vector<std::string> texts;
    while (const auto sample = remark().next()) texts.push_back(sample->value.text);
    return texts;
  }
  gecos::Result<std::vector<std::int32_t>> steps() override {
    std::vector<std::int32_t> counts;
    while (const auto sample = alter().next()) counts.push_back(sample->value.count);
    return counts;
  }
  gecos::Result<std::string> told(const std::string& stream) override {
    if (stream == "alter") return in_words(alter().report());
    if (stream == "speed") return in_words(speed().report());
    return in_words(remark().report());
  }
  gecos::Result<std::int32_t> feet() override { return 2; }
};

}  // namespace feeding
