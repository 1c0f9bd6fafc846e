// The arms that tests try things on.
#pragma once

#include <random>

#include "robcl/arm/model.hpp"
#include "robcl/frames/units.hpp"

namespace robcl {

inline arm::JointValues joints(std::initializer_list<double> degrees) {
  arm::JointValues values(static_cast<Eigen::Index>(degrees.size()));
  Eigen::Index i = 0;
  for (const double angle : degrees) values[i++] = deg(angle);
  return values;
}

inline arm::ArmModel rx90() {
  return arm::ArmModel::from_urdf_file(ROBCL_SOURCE_DIR "/devices/arms/rx90.urdf", "foot", "flange",
                                       0.25)
      .value()
      .with_front(joints({0, -20, 110, 0, -45, 0}))
      .value();
}

/// Without pedestal and flange, as in the published table.
inline arm::ArmModel puma560() {
  return arm::ArmModel::from_urdf_file(ROBCL_SOURCE_DIR "/tests/cpp/robcl/puma560.urdf", "link0",
                                       "link7", 0.25)
      .value()
      .with_front(joints({0, 45, -180, 0, 45, 0}))  // qn
      .value();
}

inline arm::ArmModel seven_axes() {
  return arm::ArmModel::from_urdf_file(ROBCL_SOURCE_DIR "/devices/arms/iiwa14.urdf", "base",
                                       "flange", 0.25)
      .value();
}

inline arm::ArmModel ur5() {
  return arm::ArmModel::from_urdf_file(ROBCL_SOURCE_DIR "/tests/cpp/robcl/ur5.urdf", "base",
                                       "flange", 0.25)
      .value();
}

inline arm::ArmModel five_axes() {
  return arm::ArmModel::from_urdf_file(ROBCL_SOURCE_DIR "/tests/cpp/robcl/five_axes.urdf", "base",
                                       "flange", 0.25)
      .value();
}

/// Joint positions anywhere inside the limits, the same in every run.
class RandomJoints {
 public:
  RandomJoints(const arm::ArmModel& model, unsigned seed) : model_(model), engine_(seed) {}

  arm::JointValues operator()() {
    arm::JointValues values(model_.axes());
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const auto& limits = model_.limits()[static_cast<std::size_t>(i)];
      values[i] = std::uniform_real_distribution<double>(limits.lower, limits.upper)(engine_);
    }
    return values;
  }

 private:
  const arm::ArmModel& model_;
  std::mt19937 engine_;
};

}  // namespace robcl
