// The program robcl-puma560: serves a simulated Unimation Puma 560.
#include "devices/arm/arm_program.hpp"
#include "devices/puma560/puma560_files.hpp"
#include "robcl/puma560_server.hpp"

namespace {

class Puma560 final : public robcl::Puma560Servant, public devices::SixAxisServant {
 public:
  using devices::SixAxisServant::SixAxisServant;
};

}  // namespace

int main(int count, char** words) {
  return devices::serve_arm<Puma560>({"robcl-puma560", devices::puma560_files}, count, words);
}
