#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gecos/access/zone.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/presence_server.hpp"

namespace devices {

/// The servant of a zone: implements the interface `gecos::Zone` with a gecos::access::Zone.
/// Thread-safe.
class ZoneServant final : public gecos::ZoneServant {
 public:
  /// Shows a text in the laboratory, at a place where only the persons in the laboratory can read
  /// it.
  using Display = std::function<void(const std::string& text)>;

  ZoneServant(std::string name, gecos::access::Zone::Sources sources, Display display);

  /// Publishes whether a person is present. Must be called at least ten times a second.
  void publish();
  /// Simulates the sources `sources`: reports the doors among them as closed and the buttons as
  /// held.
  void simulate(const std::vector<std::string>& sources);

 private:
  gecos::Result<gecos::ZonePresence> presence() override;
  gecos::Result<void> show_code() override;
  gecos::Result<void> check_in(const std::string& code, const std::string& person,
                               double stay) override;
  gecos::Result<bool> check_out(const std::string& person) override;
  gecos::Result<void> report_door(const std::string& door, bool closed) override;
  gecos::Result<void> report_button(const std::string& button, bool held) override;

  gecos::TimePoint now() const { return clock_.since_boot(); }
  void publish_verdict() GECOS_REQUIRES(mutex_);
  void publish_change() GECOS_REQUIRES(mutex_);

  const gecos::access::Zone::Sources sources_;
  const Display display_;
  const gecos::SystemClock clock_{};
  gecos::Mutex mutex_;
  gecos::access::Zone zone_ GECOS_GUARDED_BY(mutex_);
  gecos::access::Zone::Verdict published_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace devices
