#include "devices/arm/arm_file.hpp"

#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "robcl/arm/inverse.hpp"
#include "robcl/arm/spherical_wrist.hpp"
#include "robcl/frames/units.hpp"

namespace devices {
namespace {

using robcl::arm::ArmModel;
using robcl::arm::JointValues;

std::string words(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", number);
  return text;
}

std::string words(const toml::node& value) {
  if (value.is_string()) return "a text";
  if (value.is_number()) return "a number";
  if (value.is_boolean()) return "true or false";
  if (value.is_array()) return "a list";
  if (value.is_table()) return "a table";
  return "a date or time";
}

std::size_t line_of(const toml::node& value) {
  return std::max<std::size_t>(value.source().begin.line, 1);
}

constexpr double least = 1e-6, most = 1e6;  // no arm has a limit of speed or acceleration beyond
constexpr double furthest_mm = 1e6;         // no tool is further from its flange

/// One key of a TOML file.
struct Key {
  const char* name;
  const char* wanted;  ///< what the value must be, for errors
};

/// A table of a TOML file. Reads the values of its keys. At the first wrong value, throws an
/// ArmFileError, which `parse_arm` catches and returns.
class Table {
 public:
  /// `prefix` stands before the names of the keys in error texts, for example "tool.".
  Table(const toml::table& table, std::string file, std::string prefix)
      : table_(table), file_(std::move(file)), prefix_(std::move(prefix)) {}

  void admit_only(std::initializer_list<Key> keys) const {
    std::string all;
    for (const Key& key : keys) all += (all.empty() ? "" : ", ") + prefix_ + key.name;
    for (const auto& [name, value] : table_) {
      const bool known = std::any_of(keys.begin(), keys.end(), [&, &name = name](const Key& key) {
        return name.str() == key.name;
      });
      if (known) continue;
      throw ArmFileError{file_, std::max<std::size_t>(name.source().begin.line, 1),
                         prefix_ + std::string(name.str()),
                         "this key is unknown; the keys here are " + all};
    }
  }

  [[noreturn]] void refuse(const Key& key, const std::string& why) const {
    const toml::node* value = table_.get(key.name);
    throw ArmFileError{file_, line_of(value != nullptr ? *value : table_), prefix_ + key.name, why};
  }

  bool has(const Key& key) const { return table_.contains(key.name); }

  std::string text(const Key& key) const {
    const toml::node& value = get(key);
    if (!value.is_string()) refuse_type(key, value);
    std::string text = value.ref<std::string>();
    if (text.empty()) refuse(key, std::string("the text is empty; give ") + key.wanted);
    const bool control = std::any_of(text.begin(), text.end(), [](unsigned char character) {
      return character < 0x20 || character == 0x7f;
    });
    if (control) refuse(key, std::string("the text has a control character; give ") + key.wanted);
    return text;
  }

  double positive(const Key& key) const { return positive(key, get(key)); }

  std::vector<double> numbers(const Key& key) const {
    const toml::array& list = array(key);
    std::vector<double> numbers;
    for (const toml::node& element : list) numbers.push_back(number(key, element));
    return numbers;
  }

  /// Reads a number for all of `count` joints, or a list with a number for each of them.
  std::vector<double> positive_of_each(const Key& key, std::size_t count) const {
    if (!get(key).is_array()) return std::vector<double>(count, positive(key));
    std::vector<double> numbers;
    for (const toml::node& element : array(key)) numbers.push_back(positive(key, element));
    return numbers;
  }

  Table table(const Key& key) const {
    const toml::node& value = get(key);
    if (!value.is_table()) refuse_type(key, value);
    return {*value.as_table(), file_, prefix_ + key.name + "."};
  }

 private:
  const toml::node& get(const Key& key) const {
    const toml::node* value = table_.get(key.name);
    if (value == nullptr) refuse(key, std::string("this key is missing; give ") + key.wanted);
    return *value;
  }

  const toml::array& array(const Key& key) const {
    const toml::node& value = get(key);
    if (!value.is_array()) refuse_type(key, value);
    return *value.as_array();
  }

  double number(const Key& key, const toml::node& value) const {
    const std::optional<double> number = value.is_number() ? value.value<double>() : std::nullopt;
    if (!number) refuse_type(key, value);
    if (!std::isfinite(*number)) {
      refuse(key, std::string("a number is not finite; give ") + key.wanted);
    }
    return *number;
  }

  double positive(const Key& key, const toml::node& value) const {
    const double number = this->number(key, value);
    if (!(number > 0)) refuse(key, words(number) + " is not above 0; give " + key.wanted);
    if (number < least || number > most) {
      refuse(key, words(number) + " is not between 1e-6 and 1e6; give " + key.wanted);
    }
    return number;
  }

  [[noreturn]] void refuse_type(const Key& key, const toml::node& value) const {
    refuse(key, words(value) + " does not fit here; give " + key.wanted);
  }

  const toml::table& table_;
  const std::string file_;
  const std::string prefix_;
};

constexpr Key name{"name", "the name under which clients find the arm, for example \"RX90\""};
constexpr Key description{"description",
                          "the name of the arm for people, for example \"Staeubli RX90\""};
constexpr Key urdf{"urdf", "the path of the URDF file, relative to the folder of this file"};
constexpr Key base_link{"base_link", "the link of the URDF file that stands in the world"};
constexpr Key flange_link{"flange_link", "the link of the URDF file that carries the tool"};
constexpr Key seconds_to_full_speed{
    "seconds_to_full_speed",
    "the time in s, above 0, in which a joint reaches its full speed: one for all, or a list with "
    "one for each joint"};
constexpr Key seconds_to_full_acceleration{
    "seconds_to_full_acceleration",
    "the time in s, above 0 and at most 1, in which an acceleration rises to its limit"};
constexpr Key front_deg{"front_deg",
                        "a list with an angle in degrees for each joint, at which the elbow is up, "
                        "the wrist in front of the shoulder, and the flange bent up"};
constexpr Key start_deg{"start_deg",
                        "a list with an angle in degrees for each joint, at which the simulated "
                        "arm starts"};
constexpr Key place{"place",
                    "a text that says where the arm stands, for example \"an RX90 stands on the "
                    "floor\""};
constexpr Key tool{"tool",
                   "a table for the tool: add the line [tool] at the end of this file, and below "
                   "it offset_mm, speed_m_per_s, acceleration_m_per_s2, turn_speed_deg_per_s and "
                   "turn_acceleration_deg_per_s2"};
constexpr Key offset_mm{"offset_mm",
                        "a list of x, y and z of the tool frame, seen from the flange, in mm"};
constexpr Key offset_zyz_deg{"offset_zyz_deg",
                             "a list of the three ZYZ Euler angles of the tool frame, seen from "
                             "the flange, in degrees"};
constexpr Key speed{"speed_m_per_s", "the greatest speed of the tool in m/s, above 0"};
constexpr Key acceleration{"acceleration_m_per_s2",
                           "the greatest acceleration of the tool in m/s^2, above 0"};
constexpr Key turn_speed{"turn_speed_deg_per_s",
                         "the greatest speed in deg/s, above 0, with which the tool turns"};
constexpr Key turn_acceleration{
    "turn_acceleration_deg_per_s2",
    "the greatest acceleration in deg/s^2, above 0, with which the tool turns"};

void need_one_for_each_joint(const Table& table, const Key& key, std::size_t given,
                             const ArmModel& model) {
  const auto joints = static_cast<std::size_t>(model.axes());
  if (given == joints) return;
  std::string all;
  for (const std::string& joint : model.joint_names()) all += (all.empty() ? "" : ", ") + joint;
  table.refuse(key, "the list has " + std::to_string(given) + " values, but the arm has " +
                        std::to_string(joints) + " joints (" + all + "); give " + key.wanted);
}

ArmModel model_of(const Table& table, const ReadUrdf& read_urdf) {
  const std::string path = table.text(urdf);
  const std::string base = table.text(base_link);
  const std::string flange = table.text(flange_link);
  const auto xml = read_urdf(path);
  if (!xml) {
    table.refuse(urdf, "'" + path + "' cannot be read (" + xml.error() + "); give " + urdf.wanted);
  }
  auto model = ArmModel::from_urdf(*xml, base, flange, 1.0);
  if (!model) {
    table.refuse(urdf, "'" + path + "': " + model.error().text +
                           "; correct that file, or base_link and flange_link in this file");
  }
  const auto joints = static_cast<std::size_t>(model->axes());
  const std::vector<double> seconds = table.positive_of_each(seconds_to_full_speed, joints);
  need_one_for_each_joint(table, seconds_to_full_speed, seconds.size(), *model);
  return model->with_seconds_to_full_speed(seconds);
}

/// Returns the value of the key seconds_to_full_acceleration. Without this key, returns 0: there is
/// no limit of jerk.
double rise_of(const Table& table) {
  if (!table.has(seconds_to_full_acceleration)) return 0;
  const double seconds = table.positive(seconds_to_full_acceleration);
  if (seconds <= 1) return seconds;
  table.refuse(seconds_to_full_acceleration,
               words(seconds) + " is above 1; give " + seconds_to_full_acceleration.wanted);
}

JointValues joints_inside(const Table& table, const Key& key, const ArmModel& model) {
  const std::vector<double> degrees = table.numbers(key);
  need_one_for_each_joint(table, key, degrees.size(), model);
  JointValues joints(model.axes());
  for (std::size_t i = 0; i < degrees.size(); ++i) {
    joints[static_cast<Eigen::Index>(i)] = robcl::deg(degrees[i]);
  }
  if (const auto outside = robcl::arm::first_outside(model, joints)) {
    const std::size_t axis = outside->axis - 1;
    table.refuse(key, "joint " + std::to_string(outside->axis) + " (" + model.joint_names()[axis] +
                          ") is at " + words(degrees[axis]) + " deg, outside its travel from " +
                          words(robcl::in_deg(outside->lower)) + " to " +
                          words(robcl::in_deg(outside->upper)) +
                          " deg in the URDF file; give an angle inside it");
  }
  return joints;
}

ArmModel with_front(const Table& table, const ArmModel& model) {
  if (!table.has(front_deg)) return model;
  auto fronted = model.with_front(joints_inside(table, front_deg, model));
  if (!fronted) table.refuse(front_deg, fronted.error().text);
  try {
    if (!robcl::arm::SphericalWristInverse::for_arm(*fronted)) {
      table.refuse(front_deg,
                   "this arm has no spherical wrist, so it has no configurations; leave this key "
                   "out");
    }
  } catch (const std::invalid_argument& why) {
    table.refuse(front_deg, why.what());
  }
  return *fronted;
}

std::vector<double> three(const Table& table, const Key& key) {
  std::vector<double> numbers = table.numbers(key);
  if (numbers.size() != 3) {
    table.refuse(key,
                 "the list has " + std::to_string(numbers.size()) + " values; give " + key.wanted);
  }
  return numbers;
}

robcl::Frame offset_of(const Table& table) {
  using robcl::deg;
  using robcl::mm;
  const std::vector<double> at = three(table, offset_mm);
  for (const double coordinate : at) {
    if (std::abs(coordinate) <= furthest_mm) continue;
    table.refuse(offset_mm, words(coordinate) + " is beyond 1e6 mm; give " + offset_mm.wanted);
  }
  const std::vector<double> turned =
      table.has(offset_zyz_deg) ? three(table, offset_zyz_deg) : std::vector<double>{0, 0, 0};
  return robcl::Frame::from_euler_zyz(mm(at[0]), mm(at[1]), mm(at[2]), deg(turned[0]),
                                      deg(turned[1]), deg(turned[2]));
}

robcl::motion::ToolLimits limits_of(const Table& table) {
  return {.speed = table.positive(speed),
          .acceleration = table.positive(acceleration),
          .turn_speed = robcl::deg(table.positive(turn_speed)),
          .turn_acceleration = robcl::deg(table.positive(turn_acceleration))};
}

/// Refuses the keys of the tool if they stand in `table`, the top-level table of the file, and not
/// in the table [tool].
void refuse_tool_keys(const Table& table) {
  for (const Key& key :
       {offset_mm, offset_zyz_deg, speed, acceleration, turn_speed, turn_acceleration}) {
    if (!table.has(key)) continue;
    table.refuse(key,
                 "this key belongs to the table [tool]; write the line [tool] above the keys "
                 "of the tool, at the end of this file");
  }
}

ArmDescription arm_of(const Table& table, const ReadUrdf& read_urdf) {
  refuse_tool_keys(table);
  table.admit_only({name, description, urdf, base_link, flange_link, seconds_to_full_speed,
                    seconds_to_full_acceleration, front_deg, start_deg, place, tool});
  std::string called = table.text(name);
  std::string described = table.text(description);
  const ArmModel model = with_front(table, model_of(table, read_urdf));
  JointValues start = joints_inside(table, start_deg, model);
  std::string stands = table.text(place);
  const Table of_tool = table.table(tool);
  of_tool.admit_only(
      {offset_mm, offset_zyz_deg, speed, acceleration, turn_speed, turn_acceleration});
  return {.name = std::move(called),
          .description = std::move(described),
          .model = model,
          .start = std::move(start),
          .tool_limits = limits_of(of_tool),
          .seconds_to_full_acceleration = rise_of(table),
          .tool_offset = offset_of(of_tool),
          .place = std::move(stands)};
}

tl::expected<std::string, std::string> text_of(const std::filesystem::path& file) {
  std::error_code unknown;  // the file is then refused below
  const auto kind = std::filesystem::status(file, unknown).type();
  using Kind = std::filesystem::file_type;
  if (kind == Kind::fifo || kind == Kind::socket || kind == Kind::character) {
    return tl::unexpected(std::string("it is a pipe, a socket or a device, not a regular file"));
  }
  errno = 0;
  std::ifstream in(file);
  std::ostringstream text;
  in.peek();  // fails if `file` is a folder
  if (!in.is_open() || in.bad()) {
    return tl::unexpected(std::generic_category().message(errno == 0 ? EIO : errno));
  }
  text << in.rdbuf();
  return text.str();
}

}  // namespace

std::string to_string(const ArmFileError& error) {
  std::string text = error.file + ":";
  if (error.line != 0) text += std::to_string(error.line) + ":";
  text += " ";
  if (!error.key.empty()) text += error.key + ": ";
  return text + error.text;
}

tl::expected<ArmDescription, ArmFileError> parse_arm(const std::string& toml,
                                                     const std::string& file,
                                                     const ReadUrdf& read_urdf) {
  const toml::parse_result parsed = toml::parse(toml, file);
  if (!parsed) {
    const toml::parse_error& error = parsed.error();
    return tl::unexpected(ArmFileError{file, error.source().begin.line, "",
                                       "this is not TOML: " + std::string(error.description())});
  }
  try {
    return arm_of(Table(parsed.table(), file, ""), read_urdf);
  } catch (ArmFileError& error) {
    return tl::unexpected(std::move(error));
  }
}

tl::expected<ArmDescription, ArmFileError> read_arm(const std::filesystem::path& file) {
  const auto toml = text_of(file);
  if (!toml) {
    return tl::unexpected(ArmFileError{file.string(), 0, "",
                                       "the file cannot be read (" + toml.error() +
                                           "); give the path of the TOML file of an arm"});
  }
  return parse_arm(*toml, file.string(), [&](const std::filesystem::path& path) {
    return text_of(file.parent_path() / path);
  });
}

tl::expected<ArmDescription, ArmFileError> parse_arm(const ArmFiles& files) {
  return parse_arm(files.toml, files.file, [&](const std::filesystem::path&) {
    return tl::expected<std::string, std::string>(files.urdf);
  });
}

}  // namespace devices
