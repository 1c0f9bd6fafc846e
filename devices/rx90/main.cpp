// The program robcl-rx90: serves a simulated Staeubli RX90.
#include "arm/arm_program.hpp"
#include "robcl/rx90_server.hpp"
#include "rx90/rx90_urdf.hpp"

int main(int count, char** words) {
  const devices::ArmProgram rx90{
      .program = "robcl-rx90",
      .name = "RX90",
      .arm = "Staeubli RX90",
      .urdf = devices::rx90_urdf,
      .base_link = "foot",
      .flange_link = "flange",
      .front_degrees = {0, -20, 110, 0, -45, 0},
      // At the start, the tool is in front of the arm and points down, far from every singularity.
      .start_degrees = {0, -20, 110, 0, 90, 0},
      .place = "an RX90 weighs 111 kg and stands on the floor",
  };
  return devices::serve_arm<robcl::Rx90Servant>(rx90, count, words);
}
