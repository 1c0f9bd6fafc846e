// The program robcl-puma560: serves a simulated Unimation Puma 560.
#include "arm/arm_program.hpp"
#include "puma560/puma560_urdf.hpp"
#include "robcl/puma560_server.hpp"

int main(int count, char** words) {
  const devices::ArmProgram puma560{
      .program = "robcl-puma560",
      .name = "PUMA",
      .arm = "Unimation Puma 560",
      .urdf = devices::puma560_urdf,
      .base_link = "foot",
      .flange_link = "flange",
      .front_degrees = {0, 45, -180, 0, 45, 0},  // qn
      // At the start, the tool is in front of the arm and points down, far from every singularity.
      .start_degrees = {0, 45, -180, 0, -45, 0},
      .place = "a Puma 560 stands on its pedestal",
  };
  return devices::serve_arm<robcl::Puma560Servant>(puma560, count, words);
}
