#pragma once

#include <cstddef>
#include <vector>

namespace robcl::motion {

/// The greatest (ds/dt)² that a motion may have at each place of a path. It is linear in s between
/// two knots. The vectors that the constructor gets must exist as long as the new object.
class Ceiling {
 public:
  /// `places` has s at each knot of a path, and `squares` has (ds/dt)² at each knot. The ceiling is
  /// `factor` times `squares`.
  Ceiling(const std::vector<double>& places, const std::vector<double>& squares, double factor = 1)
      : places_(places), squares_(squares), factor_(factor) {}

  /// A motion at the place `s`, in the interval after the knot `knot`. `x` is (ds/dt)².
  struct State {
    std::size_t knot = 0;
    double s = 0, x = 0;
  };
  /// Two successive values of d²s/dt² that are planned for a motion. The motion has the value `u`
  /// up to the next knot, but for at most `seconds`. Then it has the value `then` for `hold`
  /// seconds.
  struct Course {
    double u = 0;
    double seconds = 0;
    double then = 0;
    double hold = 0;
    bool whole = false;  ///< each value is held up to the next knot, even after its time
  };
  /// Returns whether the motion stays below the ceiling. If the motion stops, the rest of `course`
  /// is not checked.
  bool admits(State state, const Course& course) const;

 private:
  enum class Step { Knot, Time, Stopped, Above };
  Step step(State& state, double u, double& seconds, bool whole) const;
  double height(std::size_t knot, double s) const;

  const std::vector<double>& places_;
  const std::vector<double>& squares_;
  double factor_;
};

/// Returns the greatest value from `least` to `most` that `admits` accepts, or `least` if it
/// accepts none. @pre if `admits` accepts a value, it accepts all lower ones.
template <class Predicate>
double greatest_admitted(double least, double most, const Predicate& admits) {
  if (most <= least || admits(most)) return most;
  constexpr int halvings = 26;
  for (int i = 0; i < halvings; ++i) {
    const double middle = (least + most) / 2;
    (admits(middle) ? least : most) = middle;
  }
  return least;
}

}  // namespace robcl::motion
