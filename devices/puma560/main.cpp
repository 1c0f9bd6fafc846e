// The program robcl-puma560: serves a simulated Unimation Puma 560.
#include "arm/arm_program.hpp"
#include "puma560/puma560_files.hpp"
#include "robcl/puma560_server.hpp"

int main(int count, char** words) {
  const devices::ArmProgram puma560{"robcl-puma560", devices::puma560_files};
  return devices::serve_arm<robcl::Puma560Servant>(puma560, count, words);
}
