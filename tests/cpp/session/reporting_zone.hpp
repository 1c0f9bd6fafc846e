// A zone in the hands of the test.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "gecos/presence_server.hpp"  // generated from idl/gecos/presence.gidl

namespace probe {

/// Reports ten times a second, and at once, what the test says.
class ReportingZone final : public gecos::ZoneServant {
 public:
  ReportingZone() : beat_([this](const std::stop_token& end) { run(end); }) {}

  void say(bool present, const std::string& why) {
    const std::lock_guard lock(mutex_);
    silent_ = false;
    if (present && !report_.present) ++report_.spell;
    report_.present = present;
    report_.why = why;
    publish_presence(report_);
  }
  /// Between two reports nobody was there.
  void blink() {
    const std::lock_guard lock(mutex_);
    ++report_.spell;
  }
  void fall_silent() {
    const std::lock_guard lock(mutex_);
    silent_ = true;
  }

 private:
  gecos::Result<gecos::ZonePresence> presence() override {
    const std::lock_guard lock(mutex_);
    return report_;
  }
  gecos::Result<void> show_code() override { return {}; }
  gecos::Result<void> check_in(const std::string&, const std::string&, double) override {
    return {};
  }
  gecos::Result<bool> check_out(const std::string&) override { return false; }
  gecos::Result<void> report_door(const std::string&, bool) override { return {}; }
  gecos::Result<void> report_button(const std::string&, bool) override { return {}; }

  void run(const std::stop_token& end) {
    std::unique_lock lock(mutex_);
    while (!wake_.wait_for(lock, end, std::chrono::milliseconds(100),
                           [&] { return end.stop_requested(); })) {
      if (!silent_) publish_presence(report_);
    }
  }

  std::mutex mutex_;
  std::condition_variable_any wake_;
  gecos::ZonePresence report_{false, 1, "no person has checked in; check in at CELL"};
  bool silent_ = false;
  std::jthread beat_;
};

}  // namespace probe
