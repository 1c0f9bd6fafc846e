#include "devices/arm/arm_motion.hpp"

#include <algorithm>
#include <chrono>
#include <iomanip>
#include <iterator>
#include <map>
#include <sstream>
#include <utility>

namespace devices {
namespace {

using namespace std::chrono_literals;

constexpr auto beat = 5ms;  // period at which the outcome of a running motion is polled
// A new plan does not change the next part of the running motion, so that the control loop gets the
// plan in time. This part lasts for `cycles_ahead` cycles of the control loop plus the real time in
// s that planning takes. Planning takes `time_to_plan`, and `time_to_plan_each` more for each move
// that has not ended.
constexpr double cycles_ahead = 2, time_to_plan = 0.008, time_to_plan_each = 0.0001;
// The greatest number of moves that run or wait. Each of these moves occupies one thread of the
// server.
constexpr std::size_t most_links = 64;

DriverFault stalled_loop() {
  return {"the control loop has stalled: a call of the driver does not return"};
}

/// Makes a refusal from the exception that is being handled. Some exceptions of KDL do not derive
/// from std::exception.
Refused refused_because_of_exception() {
  const std::string refused = "the motion cannot be planned: ";
  try {
    throw;
  } catch (const std::exception& why) {
    return {refused + why.what()};
  } catch (...) {
    return {refused + "an exception that is not a std::exception was thrown"};
  }
}

/// Returns the failure of a move that is not made, because an earlier move of the same caller
/// failed with `earlier`.
Refused left_out_after(const MoveFailure& earlier) {
  return {"the arm does not begin this move, because an earlier move failed: " +
          to_string(earlier)};
}

std::string not_settled(const ArmController::Outcome& outcome) {
  std::ostringstream text;
  text << "joint " << outcome.axis + 1 << " does not reach its goal: it stands "
       << std::setprecision(3) << robcl::in_deg(outcome.away)
       << " deg away from the goal; check for an obstacle or a dragging brake";
  return text.str();
}

ArmMotion::Result result_of(const ArmController::Outcome& outcome) {
  switch (outcome.end) {
    case ArmController::End::Arrived:
      return {};
    case ArmController::End::Stopped:
      return tl::unexpected(Interrupted{});
    case ArmController::End::NotSettled:
      return tl::unexpected(DriverFault{not_settled(outcome)});
    case ArmController::End::Fault:
      break;
  }
  return tl::unexpected(outcome.fault);
}

}  // namespace

std::optional<ArmController::Outcome> OutcomeWatch::look() {
  auto outcome = controller_.wait(beat);
  const std::uint64_t beats = controller_.beats();
  looks_ = beats == beats_ ? looks_ + 1 : 0;
  beats_ = beats;
  return outcome;
}

/// Reserves the arm for the calling thread. Returns nullopt, or the reason if the arm cannot be
/// reserved.
std::optional<MoveFailure> ArmMotion::claim() {
  if (busy_) return Refused{"the arm is moving for another caller; wait until it stops"};
  if (unfinished_ && !controller_.wait(0ms)) return stalled_loop();
  unfinished_ = false;
  busy_ = true;
  return std::nullopt;
}

bool ArmMotion::while_standing(const std::function<void()>& change) {
  const Lock lock(mutex_);
  if (claim()) return false;  // another caller has the arm, or its last motion has not ended
  change();
  busy_ = false;
  return true;
}

ArmMotion::Result ArmMotion::alone(const std::function<Generator(const JointValues& from)>& make,
                                   MotionWatcher& watcher) {
  return while_claimed([&] { controller_.start(make(controller_.standing_at())); }, watcher);
}

ArmMotion::Result ArmMotion::reset_drives(MotionWatcher& watcher) {
  return while_claimed([this] { controller_.reset_drives(); }, watcher);
}

/// Reserves the arm, calls `start`, and waits for the outcome. `start` must hand a motion or a
/// reset of the drives to the control loop.
ArmMotion::Result ArmMotion::while_claimed(const std::function<void()>& start,
                                           MotionWatcher& watcher) {
  {
    const Lock lock(mutex_);
    if (auto failure = claim()) return tl::unexpected(*std::move(failure));
  }
  Result result = tl::unexpected(Interrupted{});
  bool stalled = false;
  if (!watcher.interrupted()) {
    try {
      start();
    } catch (...) {  // nothing moves yet: others may have the arm again
      const Lock lock(mutex_);
      busy_ = false;
      return tl::unexpected(refused_because_of_exception());
    }
    OutcomeWatch outcome(controller_);
    std::optional<ArmController::Outcome> ended;
    while (!ended && !outcome.stalled()) {
      ended = outcome.look();
      if (watcher.interrupted()) controller_.stop();
      watcher.progress(0, 0);
    }
    stalled = !ended;
    result = ended ? result_of(*ended) : tl::unexpected(MoveFailure(stalled_loop()));
  }
  const Lock lock(mutex_);
  if (stalled) controller_.stop();  // ends the motion if the control loop continues later
  unfinished_ = stalled;
  busy_ = false;
  return result;
}

ArmMotion::Result ArmMotion::move(const Request& request, MotionWatcher& watcher) {
  Lock lock(mutex_);
  if (links_.empty() || !links_.back()->request.goes_over) {
    if (auto failure = claim()) return tl::unexpected(*std::move(failure));
  }
  Link link{request, watcher};
  links_.push_back(&link);
  if (auto failure = plan(link)) {
    links_.pop_back();
    busy_ = !links_.empty();
    return tl::unexpected(*std::move(failure));
  }
  return await(lock, link);
}

/// Waits for the result of the move `link`. The thread that waits for the first move watches the
/// motion for all moves.
ArmMotion::Result ArmMotion::await(Lock& lock, Link& link) {
  while (!link.result) {
    const bool accepted = link.part != Part::None;
    if (accepted && link.request.goes_over && !link.told && links_.size() < most_links) {
      link.told = true;
      const gecos::MutexUnlock<gecos::Mutex> unlocked(mutex_);
      link.watcher.taken();
    } else if (is_to_plan(link)) {
      join_waiting();
    } else if (links_.front() == &link) {
      watch(lock);
    } else {
      changed_.wait(lock);
    }
  }
  return *std::move(link.result);
}

/// Returns whether the thread that waits for the move `link` must make the next plan. The thread of
/// the first waiting move makes the plan, so that the thread of the running move can stop the arm
/// meanwhile.
bool ArmMotion::is_to_plan(const Link& link) const {
  if (link.part != Part::Waiting || plan_made_) return false;
  return *std::ranges::find(links_, Part::Waiting, &Link::part) == &link;
}

/// Watches the motion for at most 5 ms, and longer while another thread holds the mutex. Stops the
/// arm if a move of the motion is interrupted, ends the moves that are complete, and reports the
/// progress. Handles the end of the motion. If the control loop has stalled, ends all moves with a
/// fault.
void ArmMotion::watch(Lock&) {
  std::optional<ArmController::Outcome> ended;
  OutcomeWatch& outcome = *outcome_;
  MotionWatcher& own = links_.front()->watcher;
  // Another thread may hold the mutex for a long time while it plans the next moves. This thread
  // must be able to stop the arm meanwhile.
  mutex_.unlock();
  while (true) {
    ended = outcome.look();
    if (own.interrupted()) controller_.stop();
    if (mutex_.try_lock()) break;
    if (!ended) continue;
    mutex_.lock();
    break;
  }
  look_after_links();
  if (std::exchange(plan_made_, false)) changed_.notify_all();
  if (ended) {
    end_motion(*ended);
  } else if (outcome.stalled()) {
    controller_.stop();  // ends the motion if the control loop continues later
    unfinished_ = true;
    end_all(stalled_loop());
  }
}

/// Calls begin_or_follow, and returns a refusal if that function throws an exception. An exception
/// must not leave `move`, because it would destroy the local object `link`, whose address other
/// threads keep.
std::optional<MoveFailure> ArmMotion::plan(Link& link) {
  try {
    return begin_or_follow(link);
  } catch (...) {
    return refused_because_of_exception();
  }
}

std::optional<MoveFailure> ArmMotion::begin_or_follow(Link& link) {
  if (links_.front() == &link) return begin(link);
  const Link& before = **(links_.end() - 2);
  if (stopping_ || before.part == Part::None) return std::nullopt;
  auto move = link.request.make(planner_, before.move ? before.move->goal() : chain_->goal());
  if (!move) return move.error();
  link.move = *std::move(move);
  link.part = Part::Waiting;
  return std::nullopt;
}

std::optional<MoveFailure> ArmMotion::begin(Link& link) {
  if (link.watcher.interrupted()) return Interrupted{};
  auto move = link.request.make(planner_, controller_.standing_at());
  if (!move) return move.error();
  chain_.emplace(planner_, *std::move(move));
  playback_ = std::make_shared<robcl::motion::Playback>(chain_->plan());
  controller_.start(playback_);
  outcome_.emplace(controller_);
  stopping_ = false;
  link.part = Part::Joined;
  link.plan = plans_ = 0;
  set_times();
  return std::nullopt;
}

/// Lets the motion go over into as many of the waiting moves as possible. Making a plan may take
/// longer than a short move lasts, but one plan for all waiting moves takes about as long as a plan
/// for one of them. Therefore waiting moves are collected: at most one plan is made between two
/// calls of `watch`.
void ArmMotion::join_waiting() {
  plan_made_ = true;
  try {
    std::vector<Link*> waiting;
    std::ranges::copy_if(links_, std::back_inserter(waiting),
                         [](const Link* link) { return link->part == Part::Waiting; });
    if (!stopping_) join(waiting);
  } catch (...) {
    // The arm stops before the moves that are not part of the motion yet. If the plan of such a
    // move fails again, the move is refused with the reason.
  }
  for (Link* const link : links_) {
    if (link->part == Part::Waiting) link->leave_motion();
  }
  set_times();
}

/// Lets the motion go over into the waiting moves of `links`, up to the first move for which this
/// is impossible. Returns whether the motion can go over into all of them.
bool ArmMotion::join(std::span<Link* const> links) {
  if (go_over_into(links)) return true;
  const std::size_t half = links.size() / 2;
  return half > 0 && join(links.first(half)) && join(links.subspan(half));
}

/// Lets the motion go over into the waiting moves of `links` by one plan. Returns false, and does
/// nothing, if that is impossible.
bool ArmMotion::go_over_into(std::span<Link* const> links) {
  std::vector<robcl::motion::Move> moves;
  for (const Link* const link : links) {
    if (!link->move->stands) moves.push_back(*link->move);
  }
  std::vector<Corner> corners;
  if (!moves.empty()) {
    const double to_plan = time_to_plan + time_to_plan_each * static_cast<double>(links_.size());
    const double notice = cycles_ahead * controller_.cycle() + to_plan * clock_speed_;
    auto added = chain_->extend(moves, playback_->elapsed() + notice);
    if (!added) return false;
    corners = *std::move(added);
    playback_->append(chain_->plan(), chain_->begins());
    ++plans_;
  }
  auto corner = corners.begin();
  for (Link* const link : links) {
    if (!link->move->stands) note_corner(*link, *corner++);
    link->move.reset();
    link->part = Part::Joined;
    link->plan = plans_;
  }
  return true;
}

/// Records that the arm does not stop at the goals of the moves before `next`, but passes these
/// goals at `corner`.
void ArmMotion::note_corner(const Link& next, const Corner& corner) {
  for (Link* const before : links_) {
    if (before == &next) return;
    if (before->corner) continue;
    before->corner = corner;
    before->corner_plan = plans_;
    before->watcher.passes_goal(corner.distance);
  }
}

/// Sets the times at which the planned moves begin and end. If the path of the newest plan begins
/// behind a corner, the times of this corner do not change.
void ArmMotion::set_times() {
  const Link* before = nullptr;
  for (Link* const link : links_) {
    if (link->part != Part::Joined) return;
    if (before != nullptr && before->corner) {
      link->begins = chain_->time_at(before->corner->begins).value_or(link->begins);
    }
    link->ends =
        link->corner ? chain_->time_at(link->corner->ends).value_or(link->ends) : chain_->ends();
    before = link;
  }
}

/// Ends the moves whose corners the arm has passed, and reports the progress of the first remaining
/// move.
void ArmMotion::look_after_links() {
  const double now = playback_->elapsed(), shown = now - playback_->lag();
  const std::size_t entered = playback_->entered();
  const auto passed = [&](const Link& link) {
    return link.corner && link.corner_plan <= entered && shown >= link.ends;
  };
  while (passed(*links_.front())) end_first({});
  end_interrupted();
  if (stopping_) controller_.stop();
  const Link& first = *links_.front();
  const double whole = first.ends - first.begins, left = std::max(first.ends - now, 0.0);
  const double factor = controller_.speed_override();
  const double remaining = stopping_ ? 0 : factor > 0 ? left / factor : left;
  const bool over = left <= 0 || whole <= 0;
  first.watcher.scaled(factor);
  first.watcher.progress(over ? 1 : std::clamp(1 - left / whole, 0.0, 1.0), remaining);
}

/// Checks which moves are interrupted. If one of them is part of the running motion, the arm must
/// stop. Any other interrupted move ends at once, and the motion goes on. The moves after the
/// interrupted move are then not joined to this motion, but begin when the arm stands.
void ArmMotion::end_interrupted() {
  bool apart = false, stop = false;
  std::erase_if(links_, [&](Link* link) {
    const bool interrupted = link->watcher.interrupted();
    if (link->part == Part::Joined) {
      stop = stop || interrupted;
      return false;
    }
    apart = apart || interrupted;
    if (interrupted) {
      link->result = tl::unexpected(MoveFailure(Interrupted{}));
    } else if (apart) {
      link->leave_motion();
    }
    return interrupted;
  });
  stopping_ = stopping_ || stop;
  if (apart) changed_.notify_all();
}

/// Handles the end of a motion. Ends the moves that are complete, and begins the remaining moves
/// from rest. If the motion failed and was not merely stopped, ends all moves with its failure.
void ArmMotion::end_motion(const ArmController::Outcome& outcome) {
  const Result result = result_of(outcome);
  if (result) {
    const std::size_t entered = playback_->entered();
    const auto arrived = [&](const Link& link) {
      return link.part == Part::Joined && link.plan <= entered;
    };
    while (!links_.empty() && arrived(*links_.front())) end_first({});
  } else if (outcome.end != ArmController::End::Stopped) {
    return end_all(result.error());
  }
  go_on_from_rest();
}

/// Plans the remaining moves from rest. The arm stopped before them because it could not go over
/// into them, or because another move was interrupted. If a move is impossible, the later moves of
/// the same caller are not made.
void ArmMotion::go_on_from_rest() {
  const std::deque<Link*> left = std::exchange(links_, {});
  std::map<std::uint64_t, MoveFailure> impossible;  // the first one of each caller
  for (Link* const link : left) {
    const std::uint64_t caller = link->watcher.caller();
    link->leave_motion();
    links_.push_back(link);
    std::optional<MoveFailure> failure = Interrupted{};
    if (!link->watcher.interrupted()) {
      const auto earlier = impossible.find(caller);
      failure = earlier == impossible.end() ? plan(*link) : left_out_after(earlier->second);
      if (failure) impossible.try_emplace(caller, *failure);
    }
    if (!failure) continue;
    links_.pop_back();
    link->result = tl::unexpected(*std::move(failure));
  }
  busy_ = !links_.empty();
  changed_.notify_all();
}

void ArmMotion::end_all(const MoveFailure& failure) {
  while (!links_.empty()) end_first(tl::unexpected(failure));
  busy_ = false;
}

void ArmMotion::end_first(Result result) {
  links_.front()->result = std::move(result);
  links_.pop_front();
  changed_.notify_all();
}

}  // namespace devices
