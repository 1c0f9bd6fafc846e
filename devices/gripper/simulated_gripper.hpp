#pragma once

#include <optional>
#include <string>

#include "gecos/base/mutex.hpp"
#include "gecos/base/result.hpp"

namespace devices {

/// Two parallel jaws that close at a constant speed until they meet something, or each other.
/// Thread-safe; the gripper's periodic thread calls `step`.
class SimulatedGripper {
 public:
  struct Settings {
    double max_width = 0.110;  ///< m
    double max_force = 100;    ///< N
    double speed = 0.150;      ///< m/s at which the distance of the jaws changes
  };
  struct State {
    double width = 0;  ///< m
    double force = 0;  ///< N, 0 when nothing is held
    bool moving = false;
    bool holding = false;
    std::string held;  ///< name of the held body; empty if unknown
  };
  /// The body that the jaws meet when they close, and their distance then, m.
  struct Contact {
    double width = 0;
    std::string body;
  };
  struct OutOfRange {
    std::string what;
    double value = 0, lower = 0, upper = 0;
  };

  explicit SimulatedGripper(const Settings& settings);

  const Settings& settings() const { return settings_; }
  State state() const;

  /// Starts to move to `width` and releases a held body. If the jaws close to reach `width`, they
  /// stop at `contact`, without force.
  tl::expected<void, OutOfRange> open(double width, const std::optional<Contact>& contact);
  /// Starts to close the jaws until they press `contact` with `force`, N. Without `contact`, the
  /// jaws press each other.
  tl::expected<void, OutOfRange> close(double force, const std::optional<Contact>& contact);
  /// Stops the jaws where they are; a held body stays held.
  void halt();
  /// Moves the jaws for `seconds`.
  void step(double seconds);

 private:
  const Settings settings_;
  mutable gecos::Mutex guard_;
  State state_ GECOS_GUARDED_BY(guard_);
  double target_ GECOS_GUARDED_BY(guard_);
  double force_at_target_ GECOS_GUARDED_BY(guard_) = 0;  // N; 0: the jaws will not grip
  std::string body_at_target_ GECOS_GUARDED_BY(guard_);
};

}  // namespace devices
