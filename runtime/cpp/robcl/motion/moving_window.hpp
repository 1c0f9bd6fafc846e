#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace robcl::motion {

/// The last values of a quantity. Only the constructor allocates memory.
class MovingWindow {
 public:
  /// At first, all `size` values are `value`.
  MovingWindow(std::size_t size, double value) : values_(size, value) {}

  /// Replaces the oldest value.
  void add(double value) {
    newest_ = (newest_ + 1) % values_.size();
    values_[newest_] = value;
  }
  void fill(double value) { std::ranges::fill(values_, value); }

  double& newest() { return values_[newest_]; }
  double least() const { return std::ranges::min(values_); }
  double greatest() const { return std::ranges::max(values_); }
  bool constant() const { return least() == greatest(); }
  /// Returns the mean of the values. If all values are equal, the mean has no rounding error.
  double mean() const {
    double sum = 0;
    for (const double value : values_) sum += value - values_[newest_];
    return values_[newest_] + sum / static_cast<double>(values_.size());
  }

 private:
  std::vector<double> values_;
  std::size_t newest_ = 0;
};

}  // namespace robcl::motion
