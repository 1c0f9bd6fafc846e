// When a server counts as out of contact with the broker, and whom it knows to be revoked.

#include "gecos/session/server/broker_contact.hpp"

#include <gtest/gtest.h>

namespace gecos::session {
namespace {

using access::RevokedUser;
using std::chrono::milliseconds;
using std::chrono::seconds;

const access::UserAtHost ben{"ben", "desk"};

TEST(BrokerContact, IsNotNeededByAServerWithoutABroker) {
  FakeClock clock;
  const BrokerContact contact(clock);
  clock.advance(std::chrono::hours(1));
  EXPECT_EQ(contact.out_of_contact(), "");
}

TEST(BrokerContact, IsMissingFromTheStartUntilTheFirstAnswer) {
  FakeClock clock;
  BrokerContact contact(clock);
  contact.need();
  EXPECT_EQ(contact.out_of_contact(), "since it was started");
  contact.take(clock.since_boot(), 0, std::vector<RevokedUser>());
  EXPECT_EQ(contact.out_of_contact(), "");
}

TEST(BrokerContact, EndsThreeSecondsAfterTheLastQuestionThatWasAnswered) {
  FakeClock clock;
  BrokerContact contact(clock);
  contact.need();
  const TimePoint asked = clock.since_boot();
  clock.advance(seconds(1));
  contact.take(asked, 0, std::nullopt);  // it counts from the question, not from the answer
  clock.advance(milliseconds(1999));
  EXPECT_EQ(contact.out_of_contact(), "");
  clock.advance(milliseconds(1));
  EXPECT_EQ(contact.out_of_contact(), "for 3 s");
  clock.advance(seconds(60));
  EXPECT_EQ(contact.out_of_contact(), "for 63 s");
  contact.take(clock.since_boot(), 0, std::nullopt);
  EXPECT_EQ(contact.out_of_contact(), "");
}

TEST(BrokerContact, KeepsTheListWhileItIsOutOfContact) {
  FakeClock clock;
  BrokerContact contact(clock);
  contact.need();
  contact.take(clock.since_boot(), 7, std::vector<RevokedUser>{{"", "ben@desk"}});
  EXPECT_TRUE(contact.revokes("", ben));
  clock.advance(seconds(60));
  EXPECT_TRUE(contact.revokes("", ben));
  contact.take(clock.since_boot(), 7, std::nullopt);
  EXPECT_TRUE(contact.revokes("", ben)) << "the broker has the same list";
  contact.take(clock.since_boot(), 0, std::vector<RevokedUser>());
  EXPECT_FALSE(contact.revokes("", ben));
}

TEST(BrokerContact, DoesNotTakeAnAnswerAboutAnotherListThanItsOwn) {
  FakeClock clock;
  BrokerContact contact(clock);
  contact.need();
  contact.take(clock.since_boot(), 7, std::nullopt);
  EXPECT_EQ(contact.out_of_contact(), "since it was started");
}

}  // namespace
}  // namespace gecos::session
