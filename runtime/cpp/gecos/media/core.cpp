#include "gecos/media/core.hpp"

#include <sched.h>

namespace gecos::media {
namespace {

class RealCore final : public Core {
 public:
  std::int32_t number() const override { return running_core(); }
  void yield() const override { ::sched_yield(); }
};

}  // namespace

const Core& Core::real() {
  static const RealCore real;
  return real;
}

}  // namespace gecos::media
