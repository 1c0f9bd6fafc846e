#include "robcl/arm/model.hpp"

#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "robcl/arm/xml_nesting.hpp"
#include "robcl/frames/units.hpp"

namespace robcl::arm {
namespace {

constexpr double furthest = 1000;  // m, between two joints
// The elements of a URDF have fewer than ten levels. The URDF parser crashes at some ten thousand
// levels.
constexpr std::size_t most_levels = 100;

KDL::Vector to_kdl(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

KDL::Frame to_kdl(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  return {KDL::Rotation::Quaternion(q.x, q.y, q.z, q.w), to_kdl(pose.position)};
}

tl::unexpected<ModelError> refuse(const std::string& what) {
  return tl::unexpected(ModelError{what});
}

/// Separates the links of a robot when this object is destroyed. A link owns its children, so the
/// links of a loop would own each other and never be freed. This cannot help if the parser itself
/// refuses the robot, for example because every link is in a loop.
class SeparatedLinks {
 public:
  explicit SeparatedLinks(urdf::ModelInterfaceSharedPtr robot) : robot_(std::move(robot)) {}
  ~SeparatedLinks() {
    for (const auto& [name, link] : robot_->links_) link->child_links.clear();
  }
  SeparatedLinks(const SeparatedLinks&) = delete;
  SeparatedLinks& operator=(const SeparatedLinks&) = delete;

 private:
  const urdf::ModelInterfaceSharedPtr robot_;
};

/// Returns an error if joints of `robot` form a loop; nullopt if there is none. @pre each link is
/// the child of at most one joint: then the root link does not lead to the links of a loop.
std::optional<std::string> loop_of_links(const urdf::ModelInterface& robot) {
  std::set<std::string> reached;
  std::vector<urdf::LinkConstSharedPtr> next = {robot.getRoot()};
  while (!next.empty()) {
    const urdf::LinkConstSharedPtr link = next.back();
    next.pop_back();
    reached.insert(link->name);
    next.insert(next.end(), link->child_links.begin(), link->child_links.end());
  }
  for (const auto& [name, link] : robot.links_) {
    if (!reached.contains(name)) {
      return "link '" + name + "' cannot be reached from the root link '" + robot.getRoot()->name +
             "': the joints above it form a loop";
    }
  }
  return std::nullopt;
}

/// Returns an error in the joints of `robot` that the URDF parser does not find; nullopt if there
/// is no error.
std::optional<std::string> problem_of_joints(const urdf::ModelInterface& robot) {
  std::set<std::string> children;
  for (const auto& [name, joint] : robot.joints_) {
    const bool control = std::any_of(name.begin(), name.end(), [](unsigned char character) {
      return character < 0x20 || character == 0x7f;
    });
    if (name.empty() || control) {
      return "the joint above link '" + joint->child_link_name +
             "' needs a name without control characters";
    }
    if (!children.insert(joint->child_link_name).second) {
      return "link '" + joint->child_link_name + "' is the child of two joints, one of them '" +
             name + "'";
    }
  }
  return loop_of_links(robot);
}

/// Returns the joints of the chain from the link `base` to the link `flange`, in this order. The
/// result is empty if no chain of joints connects the two links.
std::vector<urdf::JointConstSharedPtr> joints_between(const urdf::ModelInterface& robot,
                                                      const std::string& base,
                                                      const std::string& flange) {
  std::vector<urdf::JointConstSharedPtr> joints;
  std::string link = flange;
  while (link != base) {
    const urdf::JointConstSharedPtr joint = robot.getLink(link)->parent_joint;
    const bool loop = joints.size() > robot.links_.size();
    if (!joint || loop) return {};
    joints.push_back(joint);
    link = joint->parent_link_name;
  }
  std::reverse(joints.begin(), joints.end());
  return joints;
}

// The greatest angle of a joint, in rad. At greater angles, rounding errors of the joint positions
// hide the small steps of a motion from one cycle to the next.
constexpr double furthest_turned = 1e6;

tl::expected<JointLimits, ModelError> limits_of(const urdf::Joint& joint,
                                                double seconds_to_full_speed) {
  const bool endless = joint.type == urdf::Joint::CONTINUOUS;
  if (!joint.limits) return refuse("joint '" + joint.name + "' needs a <limit> element");
  const urdf::JointLimits& given = *joint.limits;
  if (!(given.velocity >= 1e-6 && given.velocity <= 1e6)) {
    return refuse("joint '" + joint.name + "' needs a velocity limit from 1e-6 to 1e6 rad/s");
  }
  if (!endless && !(given.lower < given.upper)) {
    return refuse("joint '" + joint.name + "': its lower limit must be below its upper limit");
  }
  if (!endless && !(given.lower >= -furthest_turned && given.upper <= furthest_turned)) {
    return refuse("joint '" + joint.name + "' needs limits of its travel from -1e6 to 1e6 rad");
  }
  return JointLimits{endless ? -furthest_turned : given.lower,
                     endless ? furthest_turned : given.upper, given.velocity,
                     given.velocity / seconds_to_full_speed};
}

}  // namespace

tl::expected<ArmModel, ModelError> ArmModel::from_urdf(const std::string& xml,
                                                       const std::string& base_link,
                                                       const std::string& flange_link,
                                                       double seconds_to_full_speed) {
  if (nested_deeper_than(most_levels, xml)) {
    return refuse("the elements of the URDF are nested more than " + std::to_string(most_levels) +
                  " deep, or one contains '<?'");
  }
  const urdf::ModelInterfaceSharedPtr robot = urdf::parseURDF(xml);
  if (!robot) return refuse("the text is not a URDF robot; the parser printed the reason above");
  const SeparatedLinks separated_at_the_end(robot);
  if (const auto problem = problem_of_joints(*robot)) return refuse(*problem);
  for (const std::string& link : {base_link, flange_link}) {
    if (!robot->getLink(link)) return refuse("the URDF has no link '" + link + "'");
  }
  const auto joints = joints_between(*robot, base_link, flange_link);
  if (joints.empty()) {
    return refuse("link '" + flange_link + "' is not a descendant of link '" + base_link + "'");
  }

  ArmModel model;
  model.name_ = robot->getName();
  for (const urdf::JointConstSharedPtr& joint : joints) {
    const KDL::Frame place = to_kdl(joint->parent_to_joint_origin_transform);
    if (!(place.p.Norm() <= furthest)) {
      return refuse("joint '" + joint->name + "' is further than 1000 m from the one before it");
    }
    model.reach_ += place.p.Norm();
    if (joint->mimic) {
      return refuse("joint '" + joint->name + "' has a <mimic> element: it follows joint '" +
                    joint->mimic->joint_name + "', which is not supported in an arm");
    }
    if (joint->type == urdf::Joint::FIXED) {
      model.chain_.addSegment(
          KDL::Segment(joint->child_link_name, KDL::Joint(joint->name, KDL::Joint::None), place));
      continue;
    }
    if (joint->type != urdf::Joint::REVOLUTE && joint->type != urdf::Joint::CONTINUOUS) {
      return refuse("joint '" + joint->name +
                    "' is not revolute, continuous or fixed; other types are not supported");
    }
    if (const double length = to_kdl(joint->axis).Norm(); !(length > 1e-6 && length < 1e6)) {
      return refuse("joint '" + joint->name + "' has an <axis> without a direction");
    }
    auto limits = limits_of(*joint, seconds_to_full_speed);
    if (!limits) return tl::unexpected(limits.error());
    const KDL::Joint turning(joint->name, place.p, place.M * to_kdl(joint->axis),
                             KDL::Joint::RotAxis);
    model.chain_.addSegment(KDL::Segment(joint->child_link_name, turning, place));
    model.limits_.push_back(*limits);
    model.joint_names_.push_back(joint->name);
  }
  if (model.axes() == 0 || model.axes() > max_axes) {
    return refuse("the arm has " + std::to_string(model.axes()) + " moving joints; 1 to " +
                  std::to_string(max_axes) + " are supported");
  }
  return model;
}

tl::expected<ArmModel, ModelError> ArmModel::from_urdf_file(const std::filesystem::path& file,
                                                            const std::string& base_link,
                                                            const std::string& flange_link,
                                                            double seconds_to_full_speed) {
  std::ifstream in(file);
  std::ostringstream xml;
  if (in) xml << in.rdbuf();
  if (!in) return refuse(file.string() + ": cannot be read");
  auto model = from_urdf(xml.str(), base_link, flange_link, seconds_to_full_speed);
  if (!model) return refuse(file.string() + ": " + model.error().text);
  return model;
}

tl::expected<ArmModel, ModelError> ArmModel::with_front(const JointValues& front) const {
  if (front.size() != axes()) {
    return refuse("front has " + std::to_string(front.size()) + " joints, but " + name_ + " has " +
                  std::to_string(axes()));
  }
  for (Eigen::Index i = 0; i < axes(); ++i) {
    const JointLimits& limits = limits_[static_cast<std::size_t>(i)];
    if (front[i] >= limits.lower && front[i] <= limits.upper) continue;
    return refuse("joint " + std::to_string(i + 1) + " of the posture 'front' is at " +
                  std::to_string(in_deg(front[i])) + " deg, outside its travel from " +
                  std::to_string(in_deg(limits.lower)) + " to " +
                  std::to_string(in_deg(limits.upper)) + " deg");
  }
  ArmModel model = *this;
  model.front_ = front;
  return model;
}

ArmModel ArmModel::with_travel_to(const JointValues& joints) const {
  ArmModel model = *this;
  for (Eigen::Index i = 0; i < axes(); ++i) {
    JointLimits& limits = model.limits_[static_cast<std::size_t>(i)];
    limits.lower = std::min(limits.lower, joints[i]);
    limits.upper = std::max(limits.upper, joints[i]);
  }
  return model;
}

ArmModel ArmModel::with_seconds_to_full_speed(const std::vector<double>& seconds) const {
  ArmModel model = *this;
  for (std::size_t i = 0; i < model.limits_.size(); ++i) {
    model.limits_[i].acceleration = model.limits_[i].speed / seconds.at(i);
  }
  return model;
}

}  // namespace robcl::arm
