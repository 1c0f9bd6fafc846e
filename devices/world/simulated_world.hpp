// A laboratory of boxes: its bodies, their poses, and the grippers that carry them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "devices/world/box.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/result.hpp"

namespace devices {

struct SimulatedBody {
  std::string name;
  Box box;
  bool fixed = false;  ///< cannot be gripped or moved
  /// Names of the grippers that hold the body, in the order in which they took hold. The last one
  /// carries the body.
  std::vector<std::string> holders;
};

/// A simulated laboratory of bodies. When a gripper grips a body, the body is attached to the
/// gripper's carrier at the pose that the body has at that moment. Several grippers may hold one
/// body: the gripper that gripped it last carries the body, which slides through the jaws of the
/// other grippers. When the carrying gripper opens, the body stays where it is. The gripper that
/// gripped the body last among the other grippers then carries the body. A body that its last
/// holder releases falls straight down onto the body below it and keeps its orientation. A body
/// that is not held does not move, even when the body below it is taken away. Thread-safe.
class SimulatedWorld {
 public:
  struct Hit {
    double range = 0;  ///< m
    std::string body;
  };
  struct Contact {
    double width = 0;  ///< m between the jaws
    std::string body;
  };
  enum class PlaceProblem { Unknown, Held, Fixed };

  /// Size in m of the area of a jaw that touches a body: its width along x of the jaws' frame, and
  /// its length along z, the direction of approach.
  static constexpr double pad_across = 0.020, pad_along = 0.020;

  /// `floor` is the height of the floor in m; the floor is infinite. Throws std::invalid_argument
  /// if two bodies have the same name.
  SimulatedWorld(double floor, std::vector<SimulatedBody> bodies);

  std::vector<SimulatedBody> bodies() const;
  std::optional<SimulatedBody> find(std::string_view name) const;

  /// Returns the first body on the ray that starts at `origin` and goes along the z axis of
  /// `origin`; nullopt if no body is within `reach`, in m.
  std::optional<Hit> cast(const Frame& origin, double reach) const;

  /// Returns the body that the jaws of a gripper would grip if they closed now. The jaws are at the
  /// frame `jaws`, have the distance `opening` between them, and close along the y axis of `jaws`.
  /// If there are several bodies between the jaws, returns the thickest one. The jaws grip a body
  /// where it is, even if it is not in the middle.
  std::optional<Contact> between(const Frame& jaws, double opening) const;

  tl::expected<void, PlaceProblem> place(std::string_view name, const Frame& pose);

  /// Reports that `gripper` holds the body `body`, or no body if `body` is empty, and that the
  /// frame of the gripper's carrier is `carrier` now. If the gripper did not hold the body before,
  /// attaches the body to the gripper's carrier, even if other grippers hold the body. If the
  /// gripper carries the body, moves it with the carrier. Releases any other body of this gripper.
  /// Does not attach a fixed body.
  void track(const std::string& gripper, const std::string& body, const Frame& carrier);

 private:
  SimulatedBody* look_up(std::string_view name) GECOS_REQUIRES(guard_);
  void release(const std::string& gripper) GECOS_REQUIRES(guard_);
  void fall(SimulatedBody& body) GECOS_REQUIRES(guard_);

  const double floor_;
  mutable gecos::Mutex guard_;
  std::vector<SimulatedBody> bodies_ GECOS_GUARDED_BY(guard_);
  // The frame of a held body, seen from the carrier of a gripper that holds it. The key is the name
  // of the gripper. If another gripper carries the body, each call of `track` measures this frame
  // again.
  std::map<std::string, Frame> carrier_from_body_ GECOS_GUARDED_BY(guard_);
};

/// The height of the floor and the bodies of the demo laboratory. Its bodies are a table, whose top
/// is at height 0 and also carries the RX90, and a block to grip.
double demo_floor();
std::vector<SimulatedBody> demo_bodies();

}  // namespace devices
