// Passwords of a status: how a served object proves them, and how often a user may guess.
#include <regex>

#include "object_host_bench.hpp"
#include "over_media.hpp"

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

/// An object whose status another session holds with the password "sesame".
class SharedByPassword : public ServedObjects {
 protected:
  SharedByPassword() {
    acquire_with(1, "sesame");
    EXPECT_EQ(reply_to(1), Detail::Done);
    holder_ = connect();
  }
  ~SharedByPassword() override { object_->depart(holder_, ObjectHost::Departure::InOrder); }

  void guess(std::uint64_t first, int times) {
    for (int time = 0; time < times; ++time) {
      acquire_with(first + static_cast<std::uint64_t>(time), "open " + std::to_string(time));
      EXPECT_NE(failure().find("the given password is wrong"), std::string::npos) << failure();
    }
  }

  std::shared_ptr<ServerSession> holder_;
};

TEST_F(SharedByPassword, RefusesAfterFiveWrongPasswordsEvenTheRightOneAndSaysWhenToTryAgain) {
  guess(1, 5);
  acquire_with(6, "sesame");
  EXPECT_EQ(reply_to(6), Detail::Fault);
  // A minute after the first of them, which was some time ago.
  EXPECT_TRUE(std::regex_search(
      failure(), std::regex("the user of the server has given 5 wrong passwords within a minute; "
                            "try again in (60|[1-5]?[0-9]) s")))
      << failure();
  clock_.pass(61s);
  acquire_with(7, "sesame");
  EXPECT_EQ(reply_to(7), Detail::Done);
}

TEST_F(SharedByPassword, CountsNoPasswordThatIsRightAndNoMissingOne) {
  for (std::uint64_t counter = 1; counter < 7; ++counter) acquire(counter);
  for (std::uint64_t counter = 7; counter < 17; counter += 2) {
    acquire_with(counter, "sesame");
    ASSERT_EQ(reply_to(counter), Detail::Done);
    release(counter + 1, granted());
  }
  guess(17, 5);
}

TEST_F(SharedByPassword, RefusesARequestThatWouldWaitAtOnceAfterFiveWrongPasswords) {
  guess(1, 5);
  send_password(6, "sesame", 60);
  EXPECT_EQ(reply_to(6), Detail::Fault);
}

TEST_F(SharedByPassword, LetsTheSameUserSetAPasswordWhenTheStatusIsFree) {
  guess(1, 5);
  object_->depart(holder_, ObjectHost::Departure::Lost);
  acquire_with(6, "another");
  EXPECT_EQ(reply_to(6), Detail::Done);
}

TEST_F(SharedByPassword, TakesNoPasswordOverALineThatProvesNobody) {
  connection_->prove_nobody();
  send_password(1, "sesame");
  EXPECT_EQ(reply_to(1), Detail::Denied);
}

TEST_F(ServedObjects, KeepTheOrderOfRequestsWhileAPasswordIsProved) {
  send_password(1, "sesame");
  const auto first = connect();
  await_reply(1, [&] { acquire(1); });
  EXPECT_EQ(reply_to(1), Detail::Fault) << "the first has the status";
  object_->depart(first, ObjectHost::Departure::InOrder);
}

TEST_F(ServedObjects, EndWhileAPasswordIsProved) {
  send_password(1, "sesame");
  object_->close();
  EXPECT_EQ(reply_to(1), Detail::Rejected);
}

double processor_seconds() {
  timespec used{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

TEST_F(ServedObjects, DeriveNothingFromThePasswordsOfCanceledRequests) {
  const double begin = processor_seconds();
  acquire_with(1, "sesame");
  const double of_one = processor_seconds() - begin;
  release(2, granted());

  constexpr std::uint64_t canceled = 100;
  const double flood = processor_seconds();
  for (std::uint64_t counter = 3; counter < 3 + canceled; ++counter) {
    send_password(counter, "sesame", 60);
    packet(wire::PacketKind::Cancel, counter);
    ASSERT_EQ(reply_to(counter), Detail::Canceled);
  }
  acquire_with(3 + canceled, "sesame");
  EXPECT_EQ(reply_to(3 + canceled), Detail::Done);
  EXPECT_LT(processor_seconds() - flood, canceled / 2 * of_one);
}

class Passwords : public probe::OverMedia {};
PROBE_OVER_MEDIA(Passwords);

TEST_P(Passwords, AreNotGuessedByTryingMany) {
  const auto holder = connect(lab_);
  const auto lease = gecos::actor(holder, "sesame");
  ASSERT_TRUE(lease) << lease.error();
  const auto other = connect(second_lab_);
  for (int guess = 0; guess < 5; ++guess) {
    const auto refused = gecos::actor(other, "open " + std::to_string(guess));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().failure.text.find("the given password is wrong"), std::string::npos)
        << refused.error();
  }
  const auto refused = gecos::actor(other, "sesame");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().failure.text.find("5 wrong passwords within a minute; try again in "),
            std::string::npos)
      << refused.error();
  EXPECT_EQ(refused.error().holders.size(), 1u);
  EXPECT_TRUE(other.read().get()) << "everything else goes on";
}

}  // namespace
}  // namespace gecos::session
