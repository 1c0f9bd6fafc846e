// The program robcl-arm: serves the arm that a TOML file and a URDF file describe.
#include "devices/arm/arm_program.hpp"

int main(int count, char** words) { return devices::serve_arm({"robcl-arm"}, count, words); }
