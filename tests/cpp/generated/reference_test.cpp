// Objects as values: tests/idl/workshop passes tools, over every medium.
#include <gtest/gtest.h>

#include <sstream>

#include "../media/kind_names.hpp"
#include "gecos/binding.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"
#include "gecos/wire/json.hpp"
#include "workshop_client.hpp"
#include "workshop_json.hpp"
#include "workshop_server.hpp"

using gecos::Detail;
using gecos::ObjectRef;

namespace {

class PlainTool final : public workshop::ToolServant {
 protected:
  gecos::Result<workshop::Wear> state() override { return workshop::Wear{0.5, 4, -2}; }
  gecos::Result<double> weight() override { return 1.25; }
};

/// Gives what it was given.
class PlainChanger final : public workshop::ChangerServant {
 public:
  ObjectRef held;
  std::optional<ObjectRef> instead;
  std::map<std::string, ObjectRef> places;

 protected:
  gecos::Result<std::int16_t> angle() override { return std::int16_t{-20}; }
  gecos::Result<void> set_angle(std::int16_t) override { return {}; }
  gecos::Result<workshop::Finding> look() override { return workshop::Finding::make_why("new"); }
  gecos::Result<workshop::Fit> seat() override { return workshop::Fit::TIGHT; }
  gecos::Result<std::vector<std::string>> name() override { return std::vector<std::string>{}; }
  gecos::Result<ObjectRef> last() override { return held; }
  gecos::Result<void> set_last(const ObjectRef& value) override {
    held = value;
    return {};
  }
  gecos::Result<ObjectRef> current() override { return held; }
  gecos::Result<workshop::Changer_both_result> both(std::int32_t count) override {
    return workshop::Changer_both_result{.left = held, .right = {}, .count = count + 1};
  }
  gecos::Result<workshop::Place> take(const ObjectRef& which,
                                      const std::optional<ObjectRef>& other) override {
    instead = other;
    return workshop::Place{.held = which, .spare = other};
  }
  gecos::Result<workshop::Tools> among(const std::map<std::string, ObjectRef>& all) override {
    places = all;
    workshop::Tools tools;
    for (const auto& [place, tool] : all) tools.push_back(tool);
    return tools;
  }
  gecos::Result<workshop::Force> pull(const workshop::Wear&) override { return 5.0F; }
  gecos::Result<workshop::Changer_inspect_result> inspect() override {
    return workshop::Changer_inspect_result{};
  }
  gecos::Result<void> turn(double, const std::string&,
                           gecos::Execution<workshop::Turning>&) override {
    return {};
  }
  gecos::Result<void> park(gecos::Execution<>&) override { return {}; }
};

class References : public ::testing::TestWithParam<gecos::media::Kind> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(broker_.serve(broker_server_, {gecos::media::Kind::Inproc}));
    serve("CHANGER", changer_);
    serve("SCREWDRIVER", tool_);
    changer_proxy_ = create<workshop::Changer>("CHANGER");
  }
  void serve(const char* name, gecos::Servant& servant) {
    gecos::ObjectOptions served;
    served.simulated = true;
    served.media = {GetParam()};
    const auto added = server_.add(name, servant, std::move(served));
    ASSERT_TRUE(added) << added.error().text;
  }
  template <class Proxy>
  Proxy create(const char* name) {
    auto created = lab_.create<Proxy>(name);
    EXPECT_TRUE(created) << created.error();
    return created ? *created : Proxy();
  }

  gecos::Lab broker_lab_;
  gecos::broker::Broker broker_;
  gecos::Server broker_server_{broker_lab_};
  PlainTool tool_;
  PlainChanger changer_;
  gecos::Lab server_lab_;
  gecos::Server server_{server_lab_};
  gecos::Lab lab_;
  workshop::Changer changer_proxy_;
};

TEST_P(References, AProxyGoesThroughACallAndIsAProxyAgain) {
  const auto lease = gecos::actor(changer_proxy_);
  ASSERT_TRUE(lease) << lease.error();
  const auto screwdriver = create<workshop::Tool>("SCREWDRIVER");
  ASSERT_TRUE(changer_proxy_.set_last(gecos::reference(screwdriver)).get());
  const auto given = changer_proxy_.current().get();
  ASSERT_TRUE(given) << given.error();
  EXPECT_EQ(*given, gecos::reference(screwdriver));
  auto again = lab_.create<workshop::Tool>(*given);
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->weight().get().value(), 1.25);
}

TEST_P(References, TheyStandInStructsSequencesMapsAndBesideOthers) {
  const auto lease = gecos::actor(changer_proxy_);
  ASSERT_TRUE(lease) << lease.error();
  const ObjectRef a{.name = "A"}, b{.name = "B", .boot = 7};
  const auto placed = changer_proxy_.take(a, b).get();
  ASSERT_TRUE(placed) << placed.error();
  EXPECT_EQ(*placed, (workshop::Place{.held = a, .spare = b}));
  EXPECT_EQ(changer_proxy_.among({{"left", a}, {"right", b}}).get().value(),
            (workshop::Tools{a, b}));
  ASSERT_TRUE(changer_proxy_.set_last(b).get());
  const auto both = changer_proxy_.both(2).get();
  ASSERT_TRUE(both) << both.error();
  EXPECT_EQ(both->left, b);
  EXPECT_EQ(both->right, ObjectRef{});
  EXPECT_EQ(both->count, 3);
}

TEST_P(References, OneSaysWhichObjectItIs) {
  const ObjectRef reference = gecos::reference(changer_proxy_);
  EXPECT_EQ(reference.name, "CHANGER");
  EXPECT_EQ(reference.interface_hash, workshop::Changer::gecos_description().hash);
  EXPECT_EQ(reference.boot, gecos::number(gecos::session::process_incarnation()));
  EXPECT_EQ(reference.where.rfind(gecos::media::name_of({GetParam(), 0}) + ": ", 0), 0U)
      << reference.where;
}

TEST_P(References, NilIsRefusedByName) {
  EXPECT_EQ(gecos::reference(workshop::Tool()), ObjectRef{});
  const auto created = lab_.create<workshop::Tool>(ObjectRef{});
  ASSERT_FALSE(created);
  EXPECT_EQ(created.error().to_string(), "(nil): NO_SERVER: an empty name refers to no object");
}

TEST_P(References, AnotherLifeOfTheServerIsAnotherObject) {
  ObjectRef before = gecos::reference(changer_proxy_);
  ++before.boot;
  const auto created = lab_.create<workshop::Changer>(before);
  ASSERT_FALSE(created);
  ASSERT_EQ(created.error().attempts.size(), 1U);
  EXPECT_EQ(created.error().attempts[0].detail, Detail::Refused);
  EXPECT_EQ(created.error().attempts[0].reason,
            "CHANGER is served by another process than the one in the reference: the server was "
            "restarted; ask for a new reference, or create the proxy by name");
  before.boot = 0;  // a maker who did not know
  EXPECT_TRUE(lab_.create<workshop::Changer>(before));
}

TEST_P(References, AnObjectOfAnotherInterfaceIsNotTakenForIt) {
  const auto created = lab_.create<workshop::Tool>(gecos::reference(changer_proxy_));
  ASSERT_FALSE(created);
  EXPECT_EQ(
      created.error().attempts[0].reason,
      "CHANGER is a workshop::Changer, not a workshop::Tool; create a workshop::Changer, or name "
      "another object");
}

TEST_P(References, WhatIsNoTextIsNotSent) {
  const auto lease = gecos::actor(changer_proxy_);
  ASSERT_TRUE(lease) << lease.error();
  const auto refused = changer_proxy_.take(ObjectRef{.name = "\xff"}).get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, Detail::BadParameter);
}

INSTANTIATE_TEST_SUITE_P(Media, References,
                         ::testing::Values(gecos::media::Kind::Inproc, gecos::media::Kind::Shm,
                                           gecos::media::Kind::Lcm),
                         gecos::media::name_of);

/// Who may set an attribute: the setters of CHANGER are called as a program calls them.
class Setters : public References {
 protected:
  static void expect_denied(const gecos::Command<void>& set, const std::string& why) {
    const auto refused = set.get();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().detail, Detail::Denied) << refused.error();
    EXPECT_NE(refused.error().text.find(why), std::string::npos) << refused.error();
  }
  const ObjectRef one{.name = "A"}, another{.name = "B"};
  gecos::Lab other_lab_;
};

TEST_P(Setters, NeedTheStatusThatTheInterfaceNames) {
  expect_denied(changer_proxy_.set_last(one), "'last=' of CHANGER needs actor status");
  EXPECT_EQ(changer_proxy_.last().get().value(), ObjectRef{});
  EXPECT_TRUE(changer_proxy_.set_angle(-20).get()) << "it is @sensor";
  const auto lease = gecos::actor(changer_proxy_);
  ASSERT_TRUE(lease) << lease.error();
  EXPECT_TRUE(changer_proxy_.set_last(one).get());
}

TEST_P(Setters, AreRefusedWhileAnotherHolderOfTheStatusHasTakenOver) {
  const auto other = other_lab_.create<workshop::Changer>("CHANGER");
  ASSERT_TRUE(other) << other.error();
  const auto ours = gecos::actor(changer_proxy_, "two hands");
  const auto theirs = gecos::actor(*other, "two hands");
  ASSERT_TRUE(ours && theirs);
  ASSERT_TRUE(gecos::take_over(*other).get());
  ASSERT_TRUE(changer_proxy_.current().get()) << "a reading tells of the take-over";
  expect_denied(changer_proxy_.set_last(one), "'last=' of CHANGER is held off: ");
  EXPECT_TRUE(other->set_last(another).get());
  ASSERT_TRUE(gecos::give_back(*other).get());
  EXPECT_EQ(changer_proxy_.last().get().value(), another);
  EXPECT_TRUE(changer_proxy_.set_last(one).get());
}

INSTANTIATE_TEST_SUITE_P(Media, Setters,
                         ::testing::Values(gecos::media::Kind::Inproc, gecos::media::Kind::Shm,
                                           gecos::media::Kind::Lcm),
                         gecos::media::name_of);

TEST(Reference, IsPrintedAndIsJson) {
  const workshop::Place place{
      .held = {.name = "A", .interface_hash = 1, .boot = 2, .where = "shm"}};
  std::ostringstream out;
  out << place.held;
  EXPECT_NE(out.str().find("A"), std::string::npos);
  const std::string text = gecos::wire::to_json_text(place);
  const auto back = gecos::wire::from_json_text<workshop::Place>(text);
  ASSERT_TRUE(back) << text;
  EXPECT_EQ(*back, place);
}

}  // namespace
