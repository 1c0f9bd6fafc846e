#pragma once

#include <optional>
#include <string>

#include "gecos/base/mutex.hpp"
#include "gecos/base/result.hpp"

namespace devices {

/// A gripper with two parallel jaws. The jaws close at a constant speed until they touch a body or
/// each other. Thread-safe; a periodic thread calls `step`.
class SimulatedGripper {
 public:
  struct Settings {
    double max_width = 0.110;  ///< m
    double max_force = 100;    ///< N
    double speed = 0.150;      ///< m/s, change of the distance between the jaws
  };
  struct State {
    double width = 0;  ///< m
    double force = 0;  ///< N, 0 when nothing is held
    bool moving = false;
    bool holding = false;
    std::string held;  ///< name of the held body; empty if unknown
  };
  /// The body that the jaws touch when they close, and the distance between the jaws at that
  /// moment, in m.
  struct Contact {
    double width = 0;
    std::string body;
  };
  /// The refused width in m, or the refused force in N, and the limits.
  struct OutOfRange {
    double value = 0, lower = 0, upper = 0;
  };

  explicit SimulatedGripper(const Settings& settings);

  const Settings& settings() const { return settings_; }
  State state() const;

  /// Releases a held body and starts to move the jaws until the distance between them is `width`.
  /// If the jaws come closer together for this and `contact` has a body, they stop when they touch
  /// the body, and do not grip it.
  tl::expected<void, OutOfRange> open(double width, const std::optional<Contact>& contact);
  /// Starts to close the jaws until they press the body of `contact` with `force`, in N. If there
  /// is no body, the jaws close until they touch each other, and hold nothing.
  tl::expected<void, OutOfRange> close(double force, const std::optional<Contact>& contact);
  /// Stops the jaws where they are. A held body stays held.
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
