#include "gecos/session/client/refused_operations.hpp"

#include <gtest/gtest.h>

#include <array>
#include <sstream>

#include "gecos/binding.hpp"
#include "gecos/media/lcm/lcm.hpp"
#include "gecos/media/shm/shm.hpp"
#include "gecos/session/client/select.hpp"
#include "over_media.hpp"

namespace {

using gecos::Detail;
using gecos::qos::Class;
using gecos::qos::Media;
using gecos::session::RefusedOperations;

gecos::OperationDescription asking(std::uint32_t code, gecos::qos::Quality quality) {
  return gecos::operation(code, "turn", 0, {.quality = quality});
}

/// One row of the table: what an operation demands, and why it is refused over shm and over lcm;
/// empty where it is not.
struct Row {
  gecos::qos::Quality asked;
  bool simulated = false;
  std::string over_shm;
  std::string over_lcm;
};

TEST(RefusedOperations, AreThoseWhoseQualityTheMediumDoesNotMeet) {
  using gecos::qos::Reliability;
  using std::chrono::milliseconds;
  const std::string no_hard_real_time =
      "class=HARD_REALTIME: the medium lcm shares a queue with other programs and may lose packets";
  const std::vector<Row> table = {
      {{.line = Class::TimeIndependent}, false, "", ""},
      {{.line = Class::SoftRealtime}, false, "", ""},
      {{.line = Class::HardRealtime}, false, "", no_hard_real_time},
      {{.line = Class::HardRealtime}, true, "", ""},
      {{.reliability = Reliability::Reliable}, false, "", ""},
      {{.reliability = Reliability::BestEffort}, false, "", ""},
      {{.media = Media::Shm}, false, "", "media=shm: lcm is not one of these media"},
      {{.media = Media::Lcm}, false, "media=lcm: shm is not one of these media", ""},
      {{.media = Media::Shm | Media::Lcm}, true, "", ""},
      {{.media = Media::Can},
       false,
       "media=can: shm is not one of these media",
       "media=can: lcm is not one of these media"},
      {{.line = Class::HardRealtime, .media = Media::Shm},
       false,
       "",
       no_hard_real_time + "; media=shm: lcm is not one of these media"},
  };
  gecos::session::Welcome server;
  server.object = "LIFT";
  for (const Row& row : table) {
    const std::array operations = {asking(7, row.asked)};
    const gecos::InterfaceDescription lift{.name = "lab::Lift", .operations = operations};
    for (const auto& [medium, why] : {std::pair(gecos::media::shm_capabilities, row.over_shm),
                                      std::pair(gecos::media::lcm_capabilities, row.over_lcm)}) {
      RefusedOperations refused({});
      refused.check_quality(lift, gecos::session::line_of(medium), row.simulated);
      const auto failure = refused.why(gecos::FunctionCode{7}, "turn", server);
      if (why.empty()) {
        EXPECT_FALSE(failure) << failure->text;
        continue;
      }
      ASSERT_TRUE(failure) << why;
      EXPECT_EQ(failure->detail, Detail::QosUnavailable);
      EXPECT_EQ(failure->text, "'turn' of LIFT was not sent over " + std::string(medium.name) +
                                   ": " + why + "; create the proxy over another medium");
      EXPECT_FALSE(refused.why(gecos::FunctionCode{8}, "look", server)) << "another operation";
    }
  }
}

/// An attribute with a getter and a stream, an event and an inward stream, whose samples are
/// RELIABLE.
struct ReliableSamples {
  static constexpr gecos::qos::Quality asked{.reliability = gecos::qos::Reliability::Reliable};
  std::array<gecos::OperationDescription, 1> operations = {asking(1, {})};
  std::array<gecos::StreamDescription, 2> streams = {
      gecos::StreamDescription{.code = gecos::FunctionCode{1}, .name = "height", .quality = asked},
      gecos::StreamDescription{
          .code = gecos::FunctionCode{2}, .name = "touched", .event = true, .quality = asked}};
  std::array<gecos::InwardDescription, 1> inward = {
      gecos::InwardDescription{.code = gecos::FunctionCode{3}, .name = "target", .quality = asked}};
  gecos::InterfaceDescription table{
      .name = "lab::Lift", .operations = operations, .streams = streams, .inward_streams = inward};
};

TEST(RefusedOperations, IncludeReliableSamplesOverAMediumThatLosesSome) {
  using gecos::qos::Traffic;
  const ReliableSamples lift;
  gecos::session::Welcome server;
  server.object = "LIFT";
  RefusedOperations refused({});
  refused.check_quality(lift.table, gecos::session::line_of(gecos::media::lcm_capabilities), true);
  for (const auto& [code, name] : {std::pair(1U, "height"), {2U, "touched"}, {3U, "target"}}) {
    const auto failure = refused.why(gecos::FunctionCode{code}, name, server, Traffic::Samples);
    ASSERT_TRUE(failure) << name;
    EXPECT_EQ(failure->detail, Detail::QosUnavailable);
    EXPECT_EQ(failure->text,
              "'" + std::string(name) +
                  "' of LIFT was not opened over lcm: reliability=RELIABLE: the medium lcm may "
                  "lose samples, "
                  "and nothing retransmits them; create the proxy over another medium");
  }
  EXPECT_FALSE(refused.why(gecos::FunctionCode{1}, "height", server)) << "the getter";

  RefusedOperations local({});
  local.check_quality(lift.table, gecos::session::line_of(gecos::media::shm_capabilities), true);
  for (const std::uint32_t code : {1U, 2U, 3U}) {
    EXPECT_FALSE(local.why(gecos::FunctionCode{code}, "", server, Traffic::Samples)) << code;
  }
}

TEST(RefusedOperations, AreToldWithAllTermsOfAStreamAndThoseOfItsGetter) {
  using gecos::qos::Traffic;
  ReliableSamples lift;
  lift.operations[0].quality.media = Media::Shm;
  lift.streams[0].quality.media = Media::Shm;
  const auto lcm = gecos::session::line_of(gecos::media::lcm_capabilities);
  const std::string media = "media=shm: lcm is not one of these media";
  const std::string both =
      "reliability=RELIABLE: the medium lcm may lose samples, and nothing retransmits them; " +
      media;
  const auto found = gecos::session::unsuited_members(lift.table, lcm, false);
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(gecos::to_string(found[0].violations), media);
  EXPECT_EQ(gecos::to_string(found[1].violations), both);
  EXPECT_FALSE(found[0].samples_only);
  EXPECT_TRUE(found[1].samples_only);
  EXPECT_FALSE(found[2].samples_only) << "an event has no getter";
  EXPECT_FALSE(found[3].samples_only) << "an inward stream has no getter";

  RefusedOperations refused({});
  refused.check_quality(lift.table, lcm, false);
  const auto why = [&](Traffic traffic) {
    const auto failure = refused.why(gecos::FunctionCode{1}, "height", {}, traffic);
    return failure ? failure->text : "";
  };
  EXPECT_NE(why(Traffic::Samples).find("lcm: " + both + "; "), std::string::npos);
  EXPECT_NE(why(Traffic::Calls).find("lcm: " + media + "; "), std::string::npos);
}

TEST(RefusedOperations, ThatDifferAreRefusedWhateverTheyDemand) {
  const std::array operations = {asking(7, {.media = Media::Can})};
  const gecos::InterfaceDescription lift{.name = "lab::Lift", .operations = operations};
  RefusedOperations refused({gecos::FunctionCode{7}});
  refused.check_quality(lift, gecos::session::line_of(gecos::media::shm_capabilities), false);
  const auto failure = refused.why(gecos::FunctionCode{7}, "turn", {});
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->detail, Detail::Refused);
}

/// A client that knows the probe by an interface whose `read` and `level` demand another medium.
class Demanding : public probe::OverMedia {
 protected:
  static const gecos::InterfaceDescription& demanding() {
    static const auto operations = [] {
      std::vector<gecos::OperationDescription> all;
      for (const auto* operation : probe::description().all_operations()) {
        all.push_back(*operation);
        if (operation->code == probe::read_code) all.back().quality.media = Media::Can;
      }
      return all;
    }();
    static const std::array streams = {gecos::StreamDescription{.code = probe::level_code,
                                                                .name = "level",
                                                                .rate_hz = 100,
                                                                .largest = 4,
                                                                .quality = {.media = Media::Can}}};
    static const gecos::InterfaceDescription described = [] {
      gecos::InterfaceDescription changed = probe::description();
      changed.operations = operations;
      changed.streams = streams;
      return changed;
    }();
    return described;
  }
};

TEST_P(Demanding, AreNamedByExplain) {
  const auto found =
      gecos::session::explain(gecos::session::LabAccess::context(lab_), demanding(), "PROBE", {});
  ASSERT_TRUE(found) << found.error();
  ASSERT_FALSE(found->media.empty());
  EXPECT_TRUE(found->media.front().suitable());
  std::ostringstream text;
  text << *found;
  const std::string medium = found->media.front().medium;
  EXPECT_NE(text.str().find("\n  " + medium + ": chosen\n"), std::string::npos) << text.str();
  const std::string why = "media=can: " + medium + " is not one of these media";
  EXPECT_NE(text.str().find("\n    not read: " + why), std::string::npos) << text.str();
  EXPECT_NE(text.str().find("\n    not the samples of level: " + why), std::string::npos)
      << text.str();
}

TEST_P(Demanding, CallsAndSubscriptionsEndAtOnceAndTheRestWorks) {
  auto created =
      gecos::session::create(gecos::session::LabAccess::context(lab_), demanding(), {"PROBE"}, {});
  ASSERT_TRUE(created) << created.error();
  gecos::session::ClientSession& session = *created->session;
  const auto call = [&](gecos::FunctionCode code) {
    return session.call(*demanding().find(code), 4,
                        [](gecos::wire::Encoder& to) { to.put(std::int32_t{0}); }, {});
  };
  const auto refused = call(probe::read_code);
  ASSERT_TRUE(refused->wait_until(gecos::TimePoint::min())) << "ends at once, without an answer";
  EXPECT_EQ(refused->failure().detail, Detail::QosUnavailable);
  EXPECT_EQ(refused->failure().state(), gecos::State::ConnectionFailed);
  const auto stream = session.subscribe(*demanding().find_stream(probe::level_code));
  ASSERT_FALSE(stream);
  EXPECT_EQ(stream.error().detail, Detail::QosUnavailable);
  EXPECT_NE(stream.error().text.find("media=can: "), std::string::npos) << stream.error().text;

  const auto looked = call(probe::look_code);
  ASSERT_TRUE(looked->wait_until(gecos::deadline_after(std::chrono::seconds(10))));
  EXPECT_EQ(looked->result().size(), sizeof(std::int32_t));
}

PROBE_OVER_MEDIA(Demanding);

}  // namespace
