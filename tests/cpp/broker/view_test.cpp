// What a visitor sees of the broker's list.
#include "gecos/broker/view.hpp"

#include <gtest/gtest.h>

namespace gecos::broker {
namespace {

using std::chrono::seconds;

constexpr TimePoint now{std::chrono::hours(1)};
const access::UserAtHost anna{"anna", "cell"};

/// One object is served by one server after the other; the second one admits anna.
class ViewTest : public ::testing::Test {
 protected:
  static Entry served_by(const std::string& user, const std::string& name = "RX90") {
    Entry entry;
    entry.name = name;
    entry.user = user;
    entry.hostname = "cell";
    return entry;
  }
  void enlist(const Entry& entry, std::vector<std::string> users) {
    ASSERT_TRUE(directory_.enlist({++session_, 0, Duration::zero()}, entry, now));
    book_.set(entry.name, {{{entry.user, "cell"}, session_, true}, 1, {std::move(users), {}, ""}},
              directory_.revision().number);
  }
  View of_anna() const { return View(directory_, book_, anna); }
  std::string changes(const ListRevision& since) const {
    const ListChanges found = of_anna().changes(since, now);
    std::string text = found.whole ? "whole" : "since";
    for (const Registration& one : found.changed) text += " " + one.entry.user;
    return text;
  }

  Directory directory_{now - seconds(60), {.life = 7}};
  access::VisitorBook book_;
  std::uint64_t session_ = 0;
};

TEST_F(ViewTest, AVisitorIsToldTheChangesOfTheObjectsThatAdmitTheUser) {
  enlist(served_by("ben"), {"anna"});
  enlist(served_by("carl", "LASER"), {});
  const ListRevision seen = of_anna().revision();
  EXPECT_EQ(changes({}), "whole ben");
  EXPECT_EQ(changes(seen), "since");
  ASSERT_TRUE(directory_.withdraw(1, "RX90"));
  EXPECT_EQ(changes(seen), "since ben");
}

TEST_F(ViewTest, AVisitorIsToldNoChangeFromBeforeTheListNamedTheUser) {
  enlist(served_by("carl"), {});
  ASSERT_TRUE(directory_.withdraw(1, "RX90"));
  enlist(served_by("ben"), {"anna"});
  const ListRevision seen = of_anna().revision();
  for (std::uint64_t invented = 0; invented < seen.number; ++invented) {
    EXPECT_EQ(changes({seen.life, invented}), "whole ben") << invented;
  }
  EXPECT_EQ(changes({seen.life, seen.number}), "since");
  EXPECT_EQ(changes({seen.life, seen.number + 1}), "whole ben");
}

TEST_F(ViewTest, AVisitorIsToldNoChangeFromBeforeAnotherObjectCameIntoView) {
  enlist(served_by("carl", "LASER"), {});
  enlist(served_by("ben"), {"anna"});
  ASSERT_TRUE(directory_.withdraw(1, "LASER"));
  enlist(served_by("dora", "LASER"), {"anna"});
  const std::uint64_t life = of_anna().revision().life;
  EXPECT_EQ(changes({life, 2}), "whole dora ben");
}

TEST_F(ViewTest, AnObjectThatDoesNotAdmitTheUserIsUnknown) {
  enlist(served_by("carl", "LASER"), {});
  enlist(served_by("ben"), {"anna"});
  const View view = of_anna();
  const auto hidden = view.look_up("LASER");
  ASSERT_FALSE(hidden);
  EXPECT_EQ(hidden.error().known, std::vector<std::string>{"RX90"});
  EXPECT_EQ(view.list().size(), 1u);
}

TEST_F(ViewTest, AnyOtherClientSeesEverything) {
  enlist(served_by("carl", "LASER"), {});
  const View all(directory_, book_, std::nullopt);
  EXPECT_EQ(all.list().size(), 1u);
  EXPECT_EQ(all.revision().life, 7u);
}

}  // namespace
}  // namespace gecos::broker
