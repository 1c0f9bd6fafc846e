// What the servers of the stress tests serve.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "record.hpp"
#include "stress/workbench_server.hpp"

namespace stress {

/// Notes when each of its handlers begins and ends, and when its start was marked.
class RecordedBench : public WorkbenchServant {
 public:
  explicit RecordedBench(const Record& record) : record_(record) {}

  /// On the thread of the handler.
  void gecos_dispatch(gecos::IncomingCall call) override {
    marked_at() = call.marked_at().value_or(gecos::TimePoint{});
    WorkbenchServant::gecos_dispatch(std::move(call));
  }

 private:
  static gecos::TimePoint& marked_at() {
    thread_local gecos::TimePoint at;
    return at;
  }

  gecos::Result<std::int64_t> tap(std::uint64_t command, std::int64_t salt) override {
    start(command, "tap");
    take_samples();
    return finish(command, "tap", answer(command, salt));
  }
  gecos::Result<std::int64_t> file(std::uint64_t command, std::int64_t salt, double seconds,
                                   gecos::Execution<>& run) override {
    start(command, "file");
    take_samples();
    run.progress(0.5);
    if (run.wait_interrupted(
            std::chrono::duration_cast<gecos::Duration>(std::chrono::duration<double>(seconds)))) {
      record_.note("finish " + std::to_string(command) + " file -");
      return tl::unexpected(gecos::Fault::interrupted());
    }
    return finish(command, "file", answer(command, salt));
  }
  gecos::Result<std::vector<std::uint8_t>> weigh(std::uint64_t command,
                                                 const std::vector<std::uint8_t>& load) override {
    start(command, "weigh");
    finish(command, "weigh", answer(command, load));
    return load;
  }
  gecos::Result<std::int64_t> gauge(std::uint64_t command, std::int64_t salt) override {
    start(command, "gauge");
    return finish(command, "gauge", answer(command, salt));
  }

  gecos::Result<std::int64_t> look(std::uint64_t command, std::int64_t salt) override {
    start(command, "look");
    return finish(command, "look", answer(command, salt));
  }

  void take_samples() {
    const auto now = [] { return gecos::SystemClock().since_boot().time_since_epoch().count(); };
    for (auto before = now(); const auto sample = push().next(); before = now()) {
      record_.note("take " + std::to_string(sample->value) + " " + std::to_string(before));
    }
  }

  void start(std::uint64_t command, const char* operation) const {
    record_.note("start " + std::to_string(command) + " " + operation + " " +
                 std::to_string(marked_at().time_since_epoch().count()));
  }
  std::int64_t finish(std::uint64_t command, const char* operation, std::int64_t result) const {
    record_.note("finish " + std::to_string(command) + " " + operation + " " +
                 std::to_string(result));
    return result;
  }

  const Record& record_;
};

/// How all of them serve it: without a device, on several threads, over one medium.
inline gecos::ObjectOptions over(gecos::media::Kind medium) {
  gecos::ObjectOptions options;
  options.simulated = true;
  options.thread_safe = true;
  options.media = {medium};
  return options;
}

}  // namespace stress
