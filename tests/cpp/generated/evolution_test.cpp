// Old clients call new servers and the other way round: tests/idl/evolution, over the runtime.
#include <gtest/gtest.h>

#include <mutex>

#include "../media/kind_names.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"

// The versions are one module in the interfaces, and so on the wire; here each has a namespace.
#define evolving cart_v1
#include "cart_v1_client.hpp"
#include "cart_v1_server.hpp"
#undef evolving
#define evolving cart_v2
#include "cart_v2_client.hpp"
#include "cart_v2_server.hpp"
#undef evolving
#define evolving cart_v3
#include "cart_v3_client.hpp"
#include "cart_v3_server.hpp"
#undef evolving

using gecos::Detail;
using namespace std::chrono_literals;

namespace {

/// What a handler heard and the test looks at. Over shm the answer says that it is there, in two
/// mappings of one memory, whose order ThreadSanitizer does not see: hence the mutex.
template <class T>
class Heard {
 public:
  void set(const T& value) {
    const std::lock_guard lock(mutex_);
    value_ = value;
  }
  T get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  T value_{};
};

/// Answers with what it was told.
class OldCart final : public cart_v1::CartServant {
 public:
  Heard<cart_v1::Goal> heard;

 protected:
  gecos::Result<cart_v1::Goal> go(const cart_v1::Goal& to, std::int32_t times) override {
    heard.set(to);
    if (times == 0) return tl::unexpected(cart_v1::Refused{"no times"});
    return to;
  }
  gecos::Result<cart_v1::Goal> place() override { return heard.get(); }
};

class NewCart final : public cart_v2::CartServant {
 public:
  Heard<cart_v2::Goal> heard;
  Heard<double> speed;

 protected:
  gecos::Result<cart_v2::Goal> go(const cart_v2::Goal& to, std::int32_t times,
                                  double with_speed) override {
    heard.set(to);
    speed.set(with_speed);
    if (times == 0) return tl::unexpected(cart_v2::Refused{"no times", 99});
    return cart_v2::Goal{cart_v2::Gear::REVERSE, {{3, 0.5}, {4, std::nullopt}}, 8};
  }
  gecos::Result<cart_v2::Goal> place() override { return heard.get(); }
  gecos::Result<std::string> model() override { return std::string("mark two"); }
};

class OtherCart final : public cart_v3::CartServant {
 protected:
  gecos::Result<cart_v3::Goal> go(const cart_v3::Goal& to, std::int32_t) override { return to; }
  gecos::Result<cart_v3::Goal> place() override { return cart_v3::Goal{}; }
};

class Evolution : public ::testing::TestWithParam<gecos::media::Kind> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(broker_.serve(broker_server_, {gecos::media::Kind::Inproc}));
  }
  template <class Proxy>
  Proxy connect(gecos::Servant& servant) {
    gecos::ObjectOptions served;
    served.simulated = true;
    served.media = {GetParam()};
    const auto added = server_.add("CART", servant, std::move(served));
    EXPECT_TRUE(added) << added.error().text;
    gecos::CreateOptions wanted;
    wanted.medium = GetParam();
    auto created = lab_.create<Proxy>("CART", wanted);
    EXPECT_TRUE(created) << created.error();
    return created ? *created : Proxy();
  }

  gecos::Lab broker_lab_;
  gecos::broker::Broker broker_;
  gecos::Server broker_server_{broker_lab_};
  OldCart old_;
  NewCart new_;
  OtherCart other_;
  gecos::Lab server_lab_;
  gecos::Server server_{server_lab_};
  gecos::Lab lab_;
};

TEST_P(Evolution, OldClientUsesNewServer) {
  const auto cart = connect<cart_v1::Cart>(new_);
  const auto gone = cart.go({cart_v1::Gear::DRIVE, {{1}, {2}}}, 1).get();
  EXPECT_EQ(new_.heard.get(), (cart_v2::Goal{cart_v2::Gear::DRIVE, {{1, {}}, {2, {}}}, 7}));
  EXPECT_EQ(new_.speed.get(), 2.5);
  ASSERT_TRUE(gone) << gone.error();
  EXPECT_EQ(*gone, (cart_v1::Goal{cart_v1::Gear::NEUTRAL, {{3}, {4}}}));

  const auto refused = cart.go({}, 0).get();
  ASSERT_FALSE(refused);
  const auto why = refused.error().as<cart_v1::Refused>();
  ASSERT_TRUE(why) << refused.error();
  EXPECT_EQ(why->why, "no times");
}

TEST_P(Evolution, NewClientUsesOldServer) {
  const auto cart = connect<cart_v2::Cart>(old_);
  const auto gone = cart.go({cart_v2::Gear::REVERSE, {{1, 0.5}, {2, {}}}, 9}, 1, 4.5).get();
  EXPECT_EQ(old_.heard.get(), (cart_v1::Goal{cart_v1::Gear::NEUTRAL, {{1}, {2}}}));
  ASSERT_TRUE(gone) << gone.error();
  EXPECT_EQ(*gone, (cart_v2::Goal{cart_v2::Gear::NEUTRAL, {{1, {}}, {2, {}}}, 7}));

  const auto refused = cart.go({}, 0).get();
  ASSERT_FALSE(refused);
  const auto why = refused.error().as<cart_v2::Refused>();
  ASSERT_TRUE(why) << refused.error();
  EXPECT_EQ(why->why, "no times");
  EXPECT_EQ(why->code, 5);

  const auto unknown = cart.model().get();
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().detail, Detail::UnknownOperation);
}

TEST_P(Evolution, SamplesOfANewServerReachAnOldClient) {
  const auto cart = connect<cart_v1::Cart>(new_);
  auto places = cart.place(gecos::stream);
  ASSERT_TRUE(places) << places.error();
  new_.publish_place({cart_v2::Gear::DRIVE, {{3, 0.5}}, 8});
  const auto sample = places->next(10s);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->value, (cart_v1::Goal{cart_v1::Gear::DRIVE, {{3}}}));
}

TEST_P(Evolution, WhatIsNotTheSameToBothIsRefusedByNameBeforeAnythingIsSent) {
  const auto cart = connect<cart_v1::Cart>(other_);
  const auto refused = cart.go({}, 1).get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().detail, Detail::Refused) << refused.error();
  EXPECT_EQ(refused.error().state(), gecos::State::ConnectionFailed) << "nothing has started";
  EXPECT_NE(refused.error().text.find("'go' of CART"), std::string::npos) << refused.error().text;

  const auto place = cart.place(gecos::stream);
  ASSERT_FALSE(place);
  EXPECT_NE(place.error().text.find("'place' of CART"), std::string::npos) << place.error();
  EXPECT_TRUE(gecos::ping(cart).get()) << "what every object answers is the same to all";
}

INSTANTIATE_TEST_SUITE_P(Over, Evolution,
                         ::testing::Values(gecos::media::Kind::Inproc, gecos::media::Kind::Shm),
                         gecos::media::name_of);

}  // namespace
