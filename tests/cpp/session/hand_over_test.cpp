// Hand-over of a status on request: a program waits in line, and the holder grants or denies.
#include <future>

#include "object_host_bench.hpp"
#include "over_media.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::Detail;

/// `holder` has actor status; `other` may wait for it.
class HandOvers : public probe::TwoProxies {
 protected:
  void SetUp() override {
    TwoProxies::SetUp();
    lease.emplace(*gecos::actor(holder));
  }
  /// `other` waits in line, on a thread of its own.
  auto ask() {
    return std::async(std::launch::async, [this] { return gecos::actor(other, {.timeout = 60s}); });
  }
  std::vector<gecos::WaitingRequest> await_request(std::uint64_t after = 0) {
    const auto asked = gecos::requests(holder, after, 60s).get();
    EXPECT_TRUE(asked) << asked.error();
    return asked.value_or(std::vector<gecos::WaitingRequest>());
  }

  std::optional<gecos::Lease> lease;
};
PROBE_OVER_MEDIA(HandOvers);

TEST_P(HandOvers, TellTheHolderWhoAsksAndGrantWhenItReleases) {
  const auto told = gecos::requests(holder, 0, 60s);  // before another program asks
  auto asking = ask();
  const auto waiting = told.get();
  ASSERT_TRUE(waiting) << waiting.error();
  ASSERT_EQ(waiting->size(), 1u);
  const gecos::WaitingRequest& request = waiting->front();
  EXPECT_EQ(request.wanted, gecos::Status::ACTOR);
  EXPECT_EQ(request.pid, getpid());
  EXPECT_GT(request.expires_in, 0);
  EXPECT_LE(request.expires_in, 60);
  lease->release();
  const auto granted = asking.get();
  ASSERT_TRUE(granted) << granted.error();
  EXPECT_EQ(other.set(1).get().value(), 1);
  EXPECT_EQ(holder.set(2).get().error().detail, Detail::Denied);
}

TEST_P(HandOvers, WaitForTheLastCommandOfTheHolderThatGrants) {
  const auto move = holder.move(1);
  servant_.await_moves(1);
  auto asking = ask();
  ASSERT_EQ(await_request().size(), 1u);
  lease->release();
  EXPECT_EQ(await_request().size(), 1u) << "the request still waits";
  servant_.open_gate();
  EXPECT_EQ(move.wait(), gecos::State::Finished);
  EXPECT_TRUE(asking.get());
}

TEST_P(HandOvers, AreDeniedByTheHolderWithItsReason) {
  auto asking = ask();
  const auto waiting = await_request();
  ASSERT_EQ(waiting.size(), 1u);
  const auto denied = gecos::deny(holder, waiting[0].id, "a part is in the gripper").get();
  ASSERT_TRUE(denied) << denied.error();
  EXPECT_TRUE(*denied);
  const auto refused = asking.get();
  ASSERT_FALSE(refused);
  const std::string& text = refused.error().failure.text;
  EXPECT_TRUE(text.starts_with("PROBE: the status is refused by its holder, ")) << text;
  EXPECT_NE(text.find(": a part is in the gripper (request "), std::string::npos) << text;
  EXPECT_EQ(refused.error().holders.size(), 1u);
  EXPECT_FALSE(gecos::deny(holder, waiting[0].id).get().value()) << "it waits no longer";
  EXPECT_EQ(holder.set(1).get().value(), 1) << "the holder keeps the status";
}

TEST_P(HandOvers, AreDeniedByHoldersAlone) {
  auto asking = ask();
  const auto waiting = await_request();
  ASSERT_EQ(waiting.size(), 1u);
  gecos::Lab third_lab(probe::patient());
  const auto stranger = gecos::deny(connect(third_lab), waiting[0].id).get();
  ASSERT_FALSE(stranger);
  ASSERT_TRUE(stranger.error().as<gecos::StatusRefused>()) << stranger.error();
  EXPECT_TRUE(stranger.error().text.starts_with(
      "PROBE: only a client that holds the status may deny it to others"))
      << stranger.error();
  lease->release();
  EXPECT_TRUE(asking.get());
}

TEST_P(HandOvers, TellTheHolderOfLaterRequestsOnly) {
  auto asking = ask();
  const auto first = await_request();
  ASSERT_EQ(first.size(), 1u);
  const auto later = gecos::requests(holder, first[0].id, 60s);
  gecos::Lab third_lab(probe::patient());
  const auto third = connect(third_lab);
  auto also_asking =
      std::async(std::launch::async, [&] { return gecos::actor(third, {.timeout = 60s}); });
  const auto both = later.get();
  ASSERT_TRUE(both) << both.error();
  ASSERT_EQ(both->size(), 2u) << "the earlier one still waits, before it";
  EXPECT_EQ(both->front().id, first[0].id);
  EXPECT_GT(both->back().id, first[0].id);
  lease->release();
  asking.get()->release();
  EXPECT_TRUE(also_asking.get());
}

TEST_P(HandOvers, ListNoRequestWhenNoneWaits) {
  EXPECT_TRUE(gecos::requests(holder).get().value().empty());
  EXPECT_FALSE(gecos::deny(holder, 1).get().value());
}

TEST_P(HandOvers, EndTheQuestionOfAHolderThatCancels) {
  auto told = gecos::requests(holder, 0, 3600s);
  ASSERT_TRUE(holder.read().get()) << "the server has the question";
  told.cancel();
  EXPECT_EQ(told.get().error().detail, Detail::Canceled);
}

}  // namespace

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

class QuestionsAboutTheLine : public ServedObjects {
 protected:
  void ask(std::uint64_t counter, double patience) {
    const GecosObject_requests_arguments asked{0, patience};
    call(counter, GecosObjectInterface::requests.code, layout::to_bytes(asked));
  }
};

TEST_F(QuestionsAboutTheLine, AreAnsweredAfterTheirPatience) {
  ask(1, 60);
  clock_.pass(59s);
  object_->on_tick(clock_.now());
  EXPECT_EQ(reply_to(1), std::nullopt);
  clock_.pass(2s);
  object_->on_tick(clock_.now());
  EXPECT_EQ(reply_to(1), Detail::Done);
}

TEST_F(QuestionsAboutTheLine, AreBoundedInNumberForEachProgramAndForAll) {
  std::uint64_t counter = 0;
  std::vector<std::shared_ptr<ServerSession>> sessions;
  for (incarnation_ = 1; incarnation_ <= 8; ++incarnation_) {
    for (int question = 0; question < 8; ++question) {
      sessions.push_back(connect());  // a program may have many proxies
      ask(++counter, 60);
      EXPECT_EQ(reply_to(counter), std::nullopt);
    }
    ask(++counter, 60);
    EXPECT_EQ(reply_to(counter), Detail::QueueFull);
    EXPECT_TRUE(failure().ends_with(
        ") already wait; ask again when one of these questions has been answered"))
        << failure();
  }
  sessions.push_back(connect());
  ask(++counter, 60);
  EXPECT_EQ(reply_to(counter), Detail::QueueFull);
  EXPECT_EQ(failure(),
            "PROBE: too many questions about requests for the status: 64 questions already wait; "
            "ask again later");
}

TEST_F(QuestionsAboutTheLine, EndWithTheObjectAndAreForgottenWithTheirSession) {
  ask(1, 60);
  const std::weak_ptr<ServerSession> before = session_;
  object_->depart(session_, ObjectHost::Departure::Lost);
  connect();
  EXPECT_TRUE(before.expired());
  ask(1, 60);
  object_->close();
  EXPECT_EQ(reply_to(1), Detail::Rejected);
}

}  // namespace
}  // namespace gecos::session
