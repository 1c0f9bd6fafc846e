// The program robcl-arm: serves the arm that a TOML file and a URDF file describe.
#include "arm/arm_program.hpp"

int main(int count, char** words) { return devices::serve_arm_of_file(count, words); }
