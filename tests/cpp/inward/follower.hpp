// Serves tests/idl/inward/feeder.gidl: what reaches a servant can be asked for.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "feeder_server.hpp"
#include "gecos/gecos.hpp"

namespace feeding {

/// Counts of a stream as the tests of both languages write them; counts that are 0 are left out.
inline std::string in_words(const gecos::FeedReport& report) {
  std::string words = "admitted " + std::to_string(report.admitted);
  const auto add = [&](const char* what, std::uint64_t count) {
    if (count != 0) words += std::string(", ") + what + " " + std::to_string(count);
  };
  add("lost", report.lost);
  add("other_session", report.other_session);
  add("session_ended", report.session_ended);
  add("no_status", report.no_status);
  add("command_not_running", report.command_not_running);
  add("too_old", report.too_old);
  add("not_newer", report.not_newer);
  add("unreadable", report.unreadable);
  if (!report.last_refusal.empty()) words += "; " + report.last_refusal;
  return words;
}

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
