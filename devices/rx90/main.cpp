// The program robcl-rx90: serves a simulated Staeubli RX90.
#include "devices/arm/arm_program.hpp"
#include "devices/rx90/rx90_files.hpp"
#include "robcl/rx90_server.hpp"

namespace {

class Rx90 final : public robcl::Rx90Servant, public devices::SixAxisServant {
 public:
  using devices::SixAxisServant::SixAxisServant;
};

}  // namespace

int main(int count, char** words) {
  return devices::serve_arm<Rx90>({"robcl-rx90", devices::rx90_files}, count, words);
}
