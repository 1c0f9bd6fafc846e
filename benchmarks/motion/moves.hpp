// What the programs of this folder share: random joint positions, and JSON.
#pragma once

#include <iostream>
#include <random>
#include <utility>
#include <vector>

#include "robcl/arm/model.hpp"

namespace benchmarks {

using robcl::arm::JointValues;

inline JointValues random_joints(const robcl::arm::ArmModel& model, std::mt19937& engine) {
  JointValues joints(model.axes());
  for (Eigen::Index i = 0; i < joints.size(); ++i) {
    const auto& limits = model.limits()[static_cast<std::size_t>(i)];
    joints[i] = std::uniform_real_distribution(limits.lower, limits.upper)(engine);
  }
  return joints;
}

/// Prints a list of numbers.
template <class Values>
void print_list(const Values& values) {
  const char* before = "[";
  for (const double value : values) std::cout << std::exchange(before, ",") << value;
  std::cout << ']';
}

/// Prints a member of an object.
template <class Values>
void print(const char* key, const Values& values) {
  std::cout << '"' << key << "\": ";
  print_list(values);
}

/// Prints a member of an object that is a list of lists.
inline void print(const char* key, const std::vector<JointValues>& all) {
  std::cout << '"' << key << "\": ";
  const char* before = "[";
  for (const JointValues& joints : all) {
    std::cout << std::exchange(before, ",");
    print_list(joints);
  }
  std::cout << ']';
}

}  // namespace benchmarks
