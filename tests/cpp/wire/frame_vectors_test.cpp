// tests/vectors/frames.json with C++ frames. tests/python/test_frames.py does the same with
// Python's.
#include <gtest/gtest.h>

#include <string>

#include "gecos/wire/contents.hpp"
#include "json.hpp"
#include "robcl/frames/frame.hpp"

namespace robcl {
namespace {

using gecos::testing::Json;
using gecos::testing::to_hex;
using gecos::wire::DecodeProblem;

static_assert(gecos::wire::GeneralContents<Frame>);

Frame made(const Json& json) {
  const std::string& how = json["make"].text;
  const std::vector<double> n = json["numbers"].numbers();
  if (how == "from_euler_zyz") return Frame::from_euler_zyz(n[0], n[1], n[2], n[3], n[4], n[5]);
  if (how == "from_euler_zyx") return Frame::from_euler_zyx(n[0], n[1], n[2], n[3], n[4], n[5]);
  if (how == "from_fixed_xyz") return Frame::from_fixed_xyz(n[0], n[1], n[2], n[3], n[4], n[5]);
  throw std::runtime_error("frames.json: unknown " + how);
}

Eigen::Matrix4d matrix_of(const Json& json) {
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      matrix(row, column) = json.items[static_cast<std::size_t>(row)]
                                .items[static_cast<std::size_t>(column)]
                                .number();
    }
  }
  return matrix;
}

const std::vector<Json>& section(const char* name) {
  static const Json vectors = Json::from_vectors("frames.json");
  return vectors[name].items;
}

TEST(FrameVectors, AnglesGiveTheExpectedMatrix) {
  ASSERT_FALSE(section("made").empty());
  for (const Json& json : section("made")) {
    const Frame frame = made(json);
    const Eigen::Matrix4d wanted = matrix_of(json["matrix"]);
    EXPECT_LT((frame.matrix() - wanted).cwiseAbs().maxCoeff(), 1e-12) << wanted;
    EXPECT_TRUE(near(Frame::from_matrix(wanted), frame, 1e-9, 1e-9)) << wanted;
  }
}

TEST(FrameVectors, SingularOrientationsAreReadByTheAgreedConvention) {
  ASSERT_FALSE(section("read").empty());
  for (const Json& json : section("read")) {
    const Frame frame = Frame::from_matrix(matrix_of(json["matrix"]));
    const auto expect_angles = [&](const char* name, const std::array<double, 3>& angles) {
      if (!json.has(name)) return;
      const std::vector<double> wanted = json[name].numbers();
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(angles[i], wanted[i], 1e-9) << name << i;
    };
    expect_angles("euler_zyz", frame.euler_zyz());
    expect_angles("euler_zyx", frame.euler_zyx());
    expect_angles("fixed_xyz", frame.fixed_xyz());
  }
}

TEST(FrameVectors, AMatrixGivesTheQuaternionWithTheAgreedSign) {
  ASSERT_GT(section("signs").size(), 500u);
  for (const Json& json : section("signs")) {
    const auto read = Frame::from_matrix(matrix_of(json["matrix"])).quaternion();
    const std::vector<double> wanted = json["quaternion"].numbers();
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(read[i], wanted[i], 1e-12);
  }
}

TEST(FrameVectors, SevenDoublesComeBackExactly) {
  ASSERT_FALSE(section("encoded").empty());
  for (const Json& json : section("encoded")) {
    const auto frame = gecos::wire::from_bytes<Frame>(json["bytes"].bytes());
    ASSERT_TRUE(frame) << frame.error().message();
    const auto [w, i, j, k] = frame->quaternion();
    EXPECT_EQ((std::vector<double>{frame->x(), frame->y(), frame->z(), w, i, j, k}),
              json["numbers"].numbers());
    EXPECT_EQ(to_hex(gecos::wire::to_bytes(*frame)), json["bytes"].text);
    EXPECT_EQ(to_hex(gecos::wire::to_message(*frame)),
              Json::from_vectors("frames.json")["fingerprint"].text + json["bytes"].text);
  }
}

TEST(FrameVectors, WhatIsNoFrameIsRefused) {
  ASSERT_FALSE(section("refused").empty());
  for (const Json& json : section("refused")) {
    const auto frame = gecos::wire::from_bytes<Frame>(json["bytes"].bytes());
    ASSERT_FALSE(frame) << json["name"].text;
    const std::string& problem = json["refused"]["problem"].text;
    const DecodeProblem wanted = problem == "InvalidValue" ? DecodeProblem::InvalidValue
                                 : problem == "Truncated"  ? DecodeProblem::Truncated
                                                           : DecodeProblem::TrailingBytes;
    EXPECT_EQ(frame.error(), (gecos::wire::DecodeError{wanted, json["refused"]["offset"].natural(),
                                                       json["refused"]["field"].text.c_str()}))
        << json["name"].text << ": " << frame.error().message();
  }
}

TEST(FrameVectors, PrintForPeople) {
  ASSERT_FALSE(section("text").empty());
  for (const Json& json : section("text")) EXPECT_EQ(to_string(made(json)), json["text"].text);
}

}  // namespace
}  // namespace robcl
