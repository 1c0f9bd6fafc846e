#include "devices/drivers/supervised_driver.hpp"

#include <chrono>
#include <cmath>
#include <exception>
#include <iomanip>
#include <sstream>
#include <utility>

namespace devices {
namespace {

constexpr double encoder_slack = 0.01;  // rad; noise or a late cycle may add this to a movement

/// Calls the function `ask` and returns its result. Returns a DriverFault if `ask` throws.
template <typename Ask>
auto caught(Ask ask) -> decltype(ask()) {
  try {
    return ask();
  } catch (const std::exception& thrown) {
    return tl::unexpected(DriverFault{"the driver threw: " + std::string(thrown.what())});
  } catch (...) {
    return tl::unexpected(
        DriverFault{"the driver threw an exception that is not a std::exception"});
  }
}

std::int64_t unix_ns() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

template <typename... Parts>
DriverFault lie(const Parts&... parts) {
  std::ostringstream text;
  text << std::setprecision(3) << "the driver's answer cannot be true: ";
  (text << ... << parts);
  return {text.str()};
}

bool fits(const JointValues& values, Eigen::Index axes) {
  return values.size() == axes && values.allFinite();
}

}  // namespace

tl::expected<JointState, DriverFault> SupervisedDriver::read() {
  last_.resize(0);
  return read_judged(0);
}

tl::expected<void, DriverFault> SupervisedDriver::enable() {
  return caught([&] { return driver_.enable(); });
}

tl::expected<void, DriverFault> SupervisedDriver::disable() {
  return caught([&] { return driver_.disable(); });
}

tl::expected<void, DriverFault> SupervisedDriver::reset() {
  return caught([&] { return driver_.reset(); });
}

tl::expected<JointState, DriverFault> SupervisedDriver::exchange(const JointCommand& command,
                                                                 double since_last) {
  if (const auto written = caught([&] { return driver_.write(command, since_last); }); !written) {
    last_.resize(0);
    return tl::unexpected(written.error());
  }
  return read_judged(since_last);
}

tl::expected<JointState, DriverFault> SupervisedDriver::read_judged(double seconds) {
  auto answer = caught([&] { return driver_.read(); });
  if (answer) {
    const std::int64_t now = unix_ns();
    if (answer->measured_at_ns == 0) answer->measured_at_ns = now;
    if (auto lie = lie_of(*answer, now, seconds)) answer = tl::unexpected(std::move(*lie));
  }
  if (answer) {
    last_ = answer->position;
  } else {
    last_.resize(0);
  }
  return answer;
}

std::optional<DriverFault> SupervisedDriver::lie_of(const JointState& state, std::int64_t now,
                                                    double seconds) const {
  const auto axes = static_cast<Eigen::Index>(limits_.size());
  if (state.position.size() != axes) {
    return lie("the answer has ", state.position.size(), " joint positions, but the arm has ", axes,
               " joints");
  }
  if (!fits(state.position, axes)) return lie("a joint position is not finite");
  if (state.velocity.size() > 0 && !fits(state.velocity, axes)) {
    return lie("the joint velocities are not ", axes, " finite numbers");
  }
  const double age = 1e-9 * static_cast<double>(now - state.measured_at_ns);
  if (age > oldest) return lie("the measurement is ", age, " s old");
  if (age < -oldest) return lie("the time of the measurement is ", -age, " s in the future");
  return jump_of(state.position, seconds);
}

std::optional<DriverFault> SupervisedDriver::jump_of(const JointValues& position,
                                                     double seconds) const {
  for (Eigen::Index i = 0; i < last_.size(); ++i) {
    const double jump = std::abs(position[i] - last_[i]);
    const double most = limits_[static_cast<std::size_t>(i)].speed * seconds;
    if (jump <= speed_margin * most + encoder_slack) continue;
    return lie("joint ", i + 1, " moved by ", jump, " rad in ", seconds,
               " s; the joint can move by at most ", most, " rad in this time");
  }
  return std::nullopt;
}

}  // namespace devices
