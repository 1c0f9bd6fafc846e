// The program robcl-rx90: serves a simulated Staeubli RX90.
#include "arm/arm_program.hpp"
#include "robcl/rx90_server.hpp"
#include "rx90/rx90_files.hpp"

int main(int count, char** words) {
  const devices::ArmProgram rx90{"robcl-rx90", devices::rx90_files};
  return devices::serve_arm<robcl::Rx90Servant>(rx90, count, words);
}
