// A laboratory of boxes: its bodies, their poses, and the grippers that carry them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/base/result.hpp"
#include "world/box.hpp"

namespace devices {

struct SimulatedBody {
  std::string name;
  Box box;
  bool fixed = false;   ///< cannot be gripped or moved
  std::string held_by;  ///< name of the gripper that holds the body; empty if none
};

/// Grasping attaches a body, in its present pose, to the gripper's carrier. A released body falls
/// straight down onto the body below and keeps its orientation. Bodies that are not held do not
/// move, even when the body below them is taken away. Thread-safe.
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

  /// Size of a finger's contact area, m: across the finger (x) and along the approach (z).
  static constexpr double pad_across = 0.020, pad_along = 0.020;

  /// The floor is infinite, at the height `floor`, m. Throws std::invalid_argument if two bodies
  /// have the same name.
  SimulatedWorld(double floor, std::vector<SimulatedBody> bodies);

  std::vector<SimulatedBody> bodies() const;
  std::optional<SimulatedBody> find(std::string_view name) const;

  /// The first body on the ray along z of `origin`, at most `reach` m away.
  std::optional<Hit> cast(const Frame& origin, double reach) const;

  /// The body that jaws at the frame `jaws` meet when they close along y from the distance
  /// `opening`. Of several bodies, returns the thickest. A body that is not in the middle is
  /// gripped where it is.
  std::optional<Contact> between(const Frame& jaws, double opening) const;

  tl::expected<void, PlaceProblem> place(std::string_view name, const Frame& pose);

  /// Reports that `gripper` holds `body` (empty: none) and that the gripper's carrier is at
  /// `carrier` now. Attaches a newly held body, moves a body that is still held, and releases the
  /// gripper's other bodies. A fixed body, or one that another gripper holds, is not attached.
  void track(const std::string& gripper, const std::string& body, const Frame& carrier);

 private:
  SimulatedBody* look_up(std::string_view name) GECOS_REQUIRES(guard_);
  void release(const std::string& gripper) GECOS_REQUIRES(guard_);
  void fall(SimulatedBody& body) GECOS_REQUIRES(guard_);

  const double floor_;
  mutable gecos::Mutex guard_;
  std::vector<SimulatedBody> bodies_ GECOS_GUARDED_BY(guard_);
  // One entry for each gripper that holds a body.
  std::map<std::string, Frame> carrier_from_body_ GECOS_GUARDED_BY(guard_);
};

/// The demo laboratory: a table with its top at height 0, the RX90's place, and a block to grip.
double demo_floor();
std::vector<SimulatedBody> demo_bodies();

}  // namespace devices
