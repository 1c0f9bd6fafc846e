// What a forked child sees of the addresses at which its parent listens.

#include <gtest/gtest.h>

#include <memory>

#include "child_process.hpp"
#include "gecos/media/inproc/inproc.hpp"

namespace gecos::media {
namespace {

TEST(InprocFork, AChildFindsNoServerOfItsParentAndMayServeTheAddressItself) {
  const auto medium = make_inproc();
  auto of_parent = medium->listen("RX90", true).value();
  ChildProcess child([&](const auto&) {
    if (medium->connect("inproc:RX90")) ::_exit(1);
    auto own = medium->listen("RX90", true);
    if (!own) ::_exit(2);
    of_parent.reset();  // must not end the child's own server
    if (!medium->connect("inproc:RX90")) ::_exit(3);
    if ((*own)->accept() == nullptr) ::_exit(4);
  });
  EXPECT_EQ(child.wait(), 0);
  EXPECT_TRUE(medium->connect("inproc:RX90"));
}

}  // namespace
}  // namespace gecos::media
