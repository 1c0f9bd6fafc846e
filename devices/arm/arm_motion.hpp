// Runs the motions of an arm, and reports to each caller the outcome of its move.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "devices/arm/arm_controller.hpp"
#include "devices/arm/motion_watcher.hpp"
#include "devices/arm/move_failure.hpp"
#include "gecos/base/mutex.hpp"
#include "robcl/motion/move_chain.hpp"
#include "robcl/motion/planner.hpp"
#include "robcl/motion/playback.hpp"

namespace devices {

/// Waits for the outcome of a motion, and notices if the control loop stalls.
class OutcomeWatch {
 public:
  explicit OutcomeWatch(ArmController& controller)
      : controller_(controller), beats_(controller.beats()) {}
  /// Waits at most 5 ms for the outcome. Returns nullopt if the motion still runs.
  std::optional<ArmController::Outcome> look();
  /// Returns whether the control loop began no cycle during the last 400 calls of `look`. The calls
  /// are counted and not the time, because time also passes while the process is suspended.
  bool stalled() const { return looks_ >= most_looks; }

 private:
  static constexpr int most_looks = 400;

  ArmController& controller_;
  std::uint64_t beats_;  // as last seen
  int looks_ = 0;        // without a new beat
};

/// Runs the motions of an arm, one at a time. A motion is one move, or several moves that go over
/// into each other. In the second case, several threads wait in `move`, each until its own move has
/// ended. The thread of the first move that has not ended watches the motion for all of them.
/// Thread-safe.
class ArmMotion {
 public:
  using Result = tl::expected<void, MoveFailure>;
  using Generator = std::shared_ptr<robcl::motion::TrajectoryGenerator>;

  /// A move that a caller wants.
  struct Request {
    /// A function that returns the move from the joint positions `from` to the goal, or the reason
    /// why this move is impossible.
    std::function<tl::expected<robcl::motion::Move, MoveFailure>(robcl::motion::Planner& planner,
                                                                 const JointValues& from)>
        make;
    /// True if the arm need not stop at the goal when the next move is requested in time.
    bool goes_over = false;
  };

  /// `controller` must exist as long as the new object. `clock_speed` is the speed of the simulated
  /// time in which the motions run (see LabClock); the time that planning takes is real time.
  ArmMotion(ArmController& controller, robcl::motion::Planner planner, double clock_speed = 1)
      : controller_(controller), clock_speed_(clock_speed), planner_(std::move(planner)) {}

  /// Makes a move. Returns when the measured joint positions show that the arm has arrived at the
  /// goal. If the arm goes over into the next move, returns when the arm is on the path of that
  /// move. Refused while the arm makes another motion, unless that motion goes over into this move.
  /// If the arm cannot go over, it stops before this move begins.
  Result move(const Request& request, MotionWatcher& watcher);

  /// Makes a motion that does not go over into another one. `make` gets the joint positions at
  /// which the arm stands, and returns the generator of the motion. Returns when the arm stands.
  Result alone(const std::function<Generator(const JointValues& from)>& make,
               MotionWatcher& watcher);

  /// Clears a fault of the drives and turns the drives on again, while the arm stands. Returns when
  /// the drives are on. Fails with the text of the fault if the drives have one, or if they are not
  /// on in time. When `watcher` interrupts the wait, the drives may still turn on.
  Result reset_drives(MotionWatcher& watcher);

  /// Calls `change` if the arm makes no motion, and lets no motion begin before `change` returns.
  /// Returns false, and does nothing, if the arm makes a motion or if a stalled control loop has
  /// not ended the last motion.
  bool while_standing(const std::function<void()>& change);

 private:
  using Corner = robcl::motion::MoveChain::Corner;

  /// Whether a move is part of the running motion. None: no; the arm must stop before the move
  /// begins. Waiting: not yet; the next plan is to include the move. Joined: yes.
  enum class Part : std::uint8_t { None, Waiting, Joined };

  /// A move that has not ended. The object is on the stack of the thread that waits for the move.
  struct Link {
    const Request& request;
    MotionWatcher& watcher;
    Part part = Part::None;
    std::optional<robcl::motion::Move> move{};  // while `part` is Waiting
    bool told = false;                          // the watcher knows that the move is taken
    std::size_t plan = 0;  // number of the first plan in `playback_` that leads to its goal
    double begins = 0;     // times in s by MoveChain
    double ends = 0;
    /// The place where the arm goes over into the next move; nullopt if the arm will stop at the
    /// goal.
    std::optional<Corner> corner{};
    std::size_t corner_plan = 0;  // number of the first plan that has the corner
    std::optional<Result> result{};

    void leave_motion() {
      part = Part::None;
      move.reset();
      begins = 0;
      corner.reset();
    }
  };
  using Lock = gecos::MutexLock<gecos::Mutex>;

  std::optional<MoveFailure> claim() GECOS_REQUIRES(mutex_);
  Result while_claimed(const std::function<void()>& start, MotionWatcher& watcher);
  Result await(Lock& lock, Link& link) GECOS_REQUIRES(mutex_);
  void watch(Lock& lock) GECOS_REQUIRES(mutex_);
  bool is_to_plan(const Link& link) const GECOS_REQUIRES(mutex_);
  /// Begins a motion with the move `link`, or lets this move wait for the next plan. Returns the
  /// reason if the move is impossible. Does nothing if the arm must stop before this move.
  std::optional<MoveFailure> plan(Link& link) GECOS_REQUIRES(mutex_);
  std::optional<MoveFailure> begin_or_follow(Link& link) GECOS_REQUIRES(mutex_);
  std::optional<MoveFailure> begin(Link& link) GECOS_REQUIRES(mutex_);
  void join_waiting() GECOS_REQUIRES(mutex_);
  bool join(std::span<Link* const> links) GECOS_REQUIRES(mutex_);
  bool go_over_into(std::span<Link* const> links) GECOS_REQUIRES(mutex_);
  void note_corner(const Link& next, const Corner& corner) GECOS_REQUIRES(mutex_);
  void set_times() GECOS_REQUIRES(mutex_);
  void look_after_links() GECOS_REQUIRES(mutex_);
  void end_interrupted() GECOS_REQUIRES(mutex_);
  void end_motion(const ArmController::Outcome& outcome) GECOS_REQUIRES(mutex_);
  void go_on_from_rest() GECOS_REQUIRES(mutex_);
  void end_all(const MoveFailure& failure) GECOS_REQUIRES(mutex_);
  void end_first(Result result) GECOS_REQUIRES(mutex_);

  ArmController& controller_;
  const double clock_speed_;

  gecos::Mutex mutex_;
  gecos::ConditionVariable changed_;  // links_ or a result
  robcl::motion::Planner planner_ GECOS_GUARDED_BY(mutex_);
  bool busy_ GECOS_GUARDED_BY(mutex_) = false;
  /// Whether the last motion still has no outcome, because the control loop stalled.
  bool unfinished_ GECOS_GUARDED_BY(mutex_) = false;
  std::deque<Link*> links_ GECOS_GUARDED_BY(mutex_);  // in the order of the motion
  std::optional<robcl::motion::MoveChain> chain_ GECOS_GUARDED_BY(mutex_);
  std::shared_ptr<robcl::motion::Playback> playback_ GECOS_GUARDED_BY(mutex_);
  std::size_t plans_ GECOS_GUARDED_BY(mutex_) = 0;   // appended to playback_
  bool plan_made_ GECOS_GUARDED_BY(mutex_) = false;  // since the last call of watch()
  std::optional<OutcomeWatch> outcome_ GECOS_GUARDED_BY(mutex_);
  bool stopping_ GECOS_GUARDED_BY(mutex_) = false;
};

}  // namespace devices
