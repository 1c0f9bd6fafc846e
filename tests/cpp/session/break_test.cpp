// An administrator ends the status of programs that nobody can reach.
#include <future>

#include "object_host_bench.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;

class Breaks : public probe::OverMedia {};
PROBE_OVER_MEDIA(Breaks);

TEST_P(Breaks, EndTheCommandsOfTheHoldersAsLostWithWhoAndWhyAndServeTheLine) {
  const auto holder = connect(lab_);
  const auto lease = gecos::actor(holder);
  ASSERT_TRUE(lease) << lease.error();
  const auto runs = holder.move(1);
  const auto waits = holder.set(2);
  servant_.await_moves(1);
  const auto other = connect(second_lab_);
  auto asking =
      std::async(std::launch::async, [&] { return gecos::actor(other, {.timeout = 60s}); });
  ASSERT_EQ(gecos::requests(other, 0, 60s).get().value().size(), 1u);

  gecos::Lab third_lab(probe::patient());
  const auto broken = gecos::break_status(connect(third_lab), "its program hangs").get();
  ASSERT_TRUE(broken) << broken.error();
  for (const auto& ended : {runs.get(), waits.get()}) {
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().detail, Detail::LeaseLost) << ended.error();
    EXPECT_NE(ended.error().text.find("an administrator, "), std::string::npos) << ended.error();
    EXPECT_NE(ended.error().text.find("pid " + std::to_string(getpid())), std::string::npos);
    EXPECT_TRUE(ended.error().text.ends_with(" broke it: its program hangs")) << ended.error();
  }
  servant_.await_event("interrupted 1");
  const auto granted = asking.get();
  ASSERT_TRUE(granted) << granted.error();
  EXPECT_EQ(other.set(3).get().value(), 3);
  EXPECT_NE(holder.set(4).get().error().detail, Detail::Done) << "the old status is over";
}

}  // namespace

namespace gecos::session {
namespace {

TEST_F(ServedObjects, LetOnlyAnAdministratorBreakAStatus) {
  acquire(1);
  const Epoch epoch = granted();
  call(2, GecosObjectInterface::break_status.code,
       layout::to_bytes(GecosObject_break_status_arguments{"mine now"}));
  EXPECT_EQ(reply_to(2), Detail::Fault);
  EXPECT_NE(failure().find("only an administrator may break a status"), std::string::npos);
  call(3, probe::set_code, {}, epoch);
  EXPECT_EQ(reply_to(3), Detail::Done) << "the holder keeps the status";
}

}  // namespace
}  // namespace gecos::session
