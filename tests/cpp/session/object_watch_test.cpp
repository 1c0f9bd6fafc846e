#include "gecos/object_watch.hpp"

#include <future>

#include "bench.hpp"

namespace {

using gecos::Presence;
using std::chrono::seconds;

class Watch : public probe::Bench {
 protected:
  static std::string next_of(gecos::ObjectWatch& watch) {
    const auto change = watch.next(seconds(20));
    if (!change) return "nothing";
    return change->entry.name + " " + std::string(to_string(change->presence));
  }
};

TEST_F(Watch, IsToldWhatIsThereAndEachChange) {
  serve("FIRST", servant_);
  gecos::ObjectWatch watch(lab_);
  EXPECT_EQ(next_of(watch), "FIRST ONLINE");
  EXPECT_FALSE(watch.next(gecos::Duration::zero()));
  probe::ProbeServant second;
  gecos::Lab lab(probe::patient());
  std::optional<gecos::Server> server(std::in_place, lab);
  gecos::ObjectOptions options;
  options.simulated = true;
  options.media = {gecos::media::Kind::Inproc};
  ASSERT_TRUE(server->add("SECOND", second, options));
  EXPECT_EQ(next_of(watch), "SECOND ONLINE");
  server.reset();
  EXPECT_EQ(next_of(watch), "SECOND GONE");
  EXPECT_EQ(watch.skipped(), 0u);
}

TEST_F(Watch, IsWokenByAChange) {
  gecos::ObjectWatch watch(lab_);
  EXPECT_FALSE(watch.next(gecos::Duration::zero()));
  auto told = std::async(std::launch::async, [&] { return next_of(watch); });
  EXPECT_EQ(told.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
  serve("PROBE", servant_);
  EXPECT_EQ(told.get(), "PROBE ONLINE");
}

TEST_F(Watch, EndsWhenItsLabIsClosed) {
  gecos::ObjectWatch watch(second_lab_);
  auto told = std::async(std::launch::async, [&] { return watch.next(gecos::Duration::max()); });
  second_lab_.close();
  EXPECT_FALSE(told.get());
  EXPECT_TRUE(watch.closed());
}

TEST_F(Watch, FindsObjectsByTheirInterface) {
  serve("PROBE", servant_);
  const auto found = gecos::find_objects(lab_, "probe::Probe");
  ASSERT_TRUE(found) << found.error();
  ASSERT_EQ(found->size(), 1u);
  EXPECT_EQ(found->front().name, "PROBE");
  EXPECT_EQ(gecos::find_objects(lab_)->size(), 1u);
  EXPECT_TRUE(gecos::find_objects(lab_, "probe::Other")->empty());
}

TEST(WatchWithoutBroker, FindsNothingAndSaysWhy) {
  gecos::LabOptions options;
  options.broker = "inproc:NOBODY";
  gecos::Lab lab(options);
  const auto found = gecos::find_objects(lab);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().find("no broker answers"), std::string::npos) << found.error();
  gecos::ObjectWatch watch(lab);
  EXPECT_FALSE(watch.next(gecos::Duration::zero()));
}

}  // namespace
