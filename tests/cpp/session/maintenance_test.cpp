#include "gecos/session/process/maintenance.hpp"

#include <gtest/gtest.h>

#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {
namespace {

// Its end meets its thread at every point of the thread's way to its first sleep.
TEST(Maintenance, EndsHoweverSoonAfterItsBeginning) {
  const Clock& clock = system_clock();
  for (int i = 0; i < 10'000; ++i) {
    const Maintenance brief(clock);
    for (int wait = i % 500; wait > 0; --wait) clock.now();
  }
}

}  // namespace
}  // namespace gecos::session
