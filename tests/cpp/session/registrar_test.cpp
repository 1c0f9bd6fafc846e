// What a server does with what a broker says of its object's name.
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <stdexcept>
#include <utility>
#include <vector>

#include "../media/scratch_directory.hpp"
#include "../settles.hpp"
#include "bench.hpp"
#include "gecos/broker_server.hpp"

namespace {

using gecos::Detail;
using gecos::State;

/// Answers as the test says, and counts how often it is asked.
class TellingBroker : public gecos::BrokerServant {
 public:
  enum class Answer { Settled, Provisional, Taken };
  void say(Answer answer) { answer_ = answer; }
  /// The next server that enlists waits for `answer`.
  void keep_waiting() { keeps_waiting_ = true; }
  void answer() { answered_.set_value(); }
  /// Called once, before the answer to a server that enlists.
  std::function<void()> on_enlist{};
  int asked() const { return asked_; }
  std::vector<std::string> withdrawn() {
    const std::lock_guard lock(mutex_);
    return withdrawn_;
  }
  double served_for() const { return served_for_; }
  /// What the server said last; nullopt: it did not say that a broker had confirmed the name.
  std::optional<double> confirmed_ago() {
    const std::lock_guard lock(mutex_);
    return confirmed_ago_;
  }
  /// The users whom the server admits, as it said last; "nothing" if it said nothing about that.
  std::string admitted() {
    const std::lock_guard lock(mutex_);
    if (!admitted_) return "nothing";
    std::string text = "users:";
    for (const auto& user : admitted_->users) text += " " + user;
    return text;
  }
  std::size_t users() {
    const std::lock_guard lock(mutex_);
    return admitted_ ? admitted_->users.size() : 0;
  }
  /// The number of what the server said last; 0 if it said nothing.
  std::uint64_t number() {
    const std::lock_guard lock(mutex_);
    return admitted_ ? admitted_->number : 0;
  }

 private:
  gecos::Result<std::optional<double>> enlist(const gecos::Entry& what, double served_for,
                                              const std::optional<gecos::AdmittedNames>& admitted,
                                              const std::optional<double>& confirmed_ago) override {
    std::unique_lock lock(mutex_);
    ++asked_;
    served_for_ = served_for;
    admitted_ = admitted;
    confirmed_ago_ = confirmed_ago;
    if (on_enlist) std::exchange(on_enlist, nullptr)();
    entry_ = what;
    lock.unlock();
    if (keeps_waiting_.exchange(false)) answered_.get_future().wait();
    if (answer_ == Answer::Settled) return std::nullopt;
    if (answer_ == Answer::Provisional) return std::optional(0.01);
    return tl::unexpected(gecos::Fault(gecos::NameTaken{what.name, "the other one, pid 4711"}));
  }
  gecos::Result<void> withdraw(const std::string& name) override {
    const std::lock_guard lock(mutex_);
    withdrawn_.push_back(name);
    return {};
  }
  gecos::Result<std::vector<gecos::SilentObject>> silent() override { return {}; }
  gecos::Result<std::vector<gecos::Entry>> query(const std::string&) override { return {}; }
  gecos::Result<gecos::ListChanges> changes(const gecos::ListRevision&) override { return {}; }
  gecos::Result<gecos::ListRevision> revision() override { return {}; }
  gecos::Result<void> free(const std::string&) override { return {}; }
  gecos::Result<gecos::RevocationList> revocations(std::uint64_t) override { return {}; }
  gecos::Result<gecos::RevocationState> behind(const std::vector<gecos::Revocation>&) override {
    return {};
  }
  gecos::Result<gecos::Entry> lookup(const std::string&) override {
    const std::lock_guard lock(mutex_);
    return entry_;
  }
  gecos::Result<std::vector<gecos::Entry>> list() override { return {}; }

  std::atomic<bool> keeps_waiting_{false};  // publishes nothing but itself
  std::promise<void> answered_;
  std::atomic<Answer> answer_{Answer::Settled};  // publishes nothing but itself
  std::atomic<int> asked_{0};                    // publishes nothing but itself
  std::atomic<double> served_for_{0};            // publishes nothing but itself
  std::mutex mutex_;
  gecos::Entry entry_;
  std::vector<std::string> withdrawn_;
  std::optional<gecos::AdmittedNames> admitted_;
  std::optional<double> confirmed_ago_;
};

class Named : public probe::NothingLeftOpen {
 protected:
  using Answer = TellingBroker::Answer;

  void serve_broker(Answer first) {
    broker_.say(first);
    gecos::ObjectOptions well_known;
    well_known.well_known = well_known.thread_safe = true;
    well_known.media = {gecos::media::Kind::Inproc};
    ASSERT_TRUE(broker_server_.add("BROKER", broker_, well_known));
  }
  tl::expected<void, gecos::ServeError> add_probe() {
    gecos::ObjectOptions options;
    options.simulated = options.thread_safe = true;
    options.media = {gecos::media::Kind::Inproc};
    options.on_stop = [this] { stopped_ = true; };
    return server_.add("PROBE", servant_, options);
  }
  void serve(Answer first) {
    serve_broker(first);
    ASSERT_TRUE(add_probe());
  }
  probe::Probe connect() {
    auto created = lab_.create<probe::Probe>("PROBE");
    EXPECT_TRUE(created) << created.error();
    return created ? *created : probe::Probe();
  }

  TellingBroker broker_;
  gecos::Lab broker_lab_;
  gecos::Server broker_server_{broker_lab_};
  probe::ProbeServant servant_;
  std::atomic<bool> stopped_{false};  // publishes nothing but itself
  gecos::Lab server_lab_{probe::patient()};
  gecos::Server server_{server_lab_};
  gecos::Lab lab_{probe::patient()};
};

TEST_F(Named, ABrokerThatMayStillGiveTheNameAwayIsAskedAgainAndToldTheAge) {
  serve(Answer::Provisional);
  EXPECT_TRUE(settles([this] { return broker_.asked() >= 3; }));
  EXPECT_GT(broker_.served_for(), 0.0);
}

TEST_F(Named, AnObjectWhoseNameGoesToAnotherIsStoppedAndSaysWhichOne) {
  serve(Answer::Provisional);
  const auto probe = connect();
  auto lease = gecos::actor(probe);
  ASSERT_TRUE(lease) << lease.error();
  auto runs = probe.finish(1);
  auto waits = probe.move(2);
  servant_.await_moves(1);
  broker_.say(Answer::Taken);
  ASSERT_EQ(runs.wait(), State::CommandFailed);
  EXPECT_EQ(runs.progress().detail, Detail::Stopped) << "it would go on after the loss of a lease";
  const auto text = runs.get().error().text;
  EXPECT_NE(text.find("the other one, pid 4711"), std::string::npos) << text;
  servant_.await_event("interrupted 1");
  ASSERT_EQ(waits.wait(), State::CommandFailed);
  EXPECT_EQ(waits.progress().detail, Detail::Stopped);
  EXPECT_TRUE(settles([this] { return stopped_.load(); }));
  EXPECT_EQ(probe.read().get().value(), 7) << "readings go on";

  const auto refused = gecos::actor(probe);
  ASSERT_FALSE(refused);
  const auto described = gecos::describe(probe).get();
  ASSERT_TRUE(described);
  EXPECT_NE(described->registration.find("another server has the name"), std::string::npos);
}

TEST_F(Named, AnObjectThatHasItsNameAgainMovesAgain) {
  serve(Answer::Provisional);
  const auto probe = connect();
  broker_.say(Answer::Taken);
  ASSERT_TRUE(settles([&] { return !gecos::actor(probe).has_value(); }));
  broker_.say(Answer::Settled);
  ASSERT_TRUE(settles([&] { return gecos::actor(probe).has_value(); }));
  EXPECT_EQ(gecos::describe(probe).get()->registration, "confirmed");
}

TEST_F(Named, AnObjectThatHasLostItsNameSaysThatItIsServedSinceThen) {
  constexpr double before = 0.3;  // s
  serve(Answer::Provisional);
  ASSERT_TRUE(settles([this] { return broker_.served_for() >= before; }));
  broker_.say(Answer::Taken);
  EXPECT_TRUE(settles([this] { return broker_.served_for() < before; }))
      << "a broker that starts later would take the name from the other server";
}

TEST_F(Named, AnObjectSaysHowLongAgoItAskedForTheNameAndGotAFinalAnswer) {
  serve(Answer::Provisional);
  ASSERT_TRUE(settles([this] { return broker_.asked() >= 3; }));
  EXPECT_EQ(broker_.confirmed_ago(), std::nullopt);
  broker_.say(Answer::Settled);
  const auto asked_again = [this] {
    const int before = broker_.asked();
    server_.allow({"user" + std::to_string(before)});
    return settles([&] { return broker_.asked() > before; });
  };
  ASSERT_TRUE(settles([&] { return asked_again() && broker_.confirmed_ago(); }));
  EXPECT_LT(*broker_.confirmed_ago(), broker_.served_for());
  broker_.say(Answer::Taken);
  server_.allow({});  // asks, and goes on asking
  EXPECT_TRUE(settles([this] { return broker_.confirmed_ago() > 0.5; }))
      << "an answer that is not final confirms nothing";
}

TEST_F(Named, ARegistrationThatIsAnsweredTooLateIsTakenBack) {
  serve_broker(Answer::Settled);
  broker_.keep_waiting();
  const auto late = add_probe();
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().text, "PROBE is not served: the broker did not answer in time");
  broker_.answer();
  EXPECT_TRUE(settles([this] { return broker_.withdrawn() == std::vector<std::string>{"PROBE"}; }));
  EXPECT_TRUE(add_probe());
}

TEST_F(Named, AnObjectThatIsNotServedAfterAllWaitsForItsHandlers) {
  serve_broker(Answer::Taken);
  broker_.keep_waiting();
  std::promise<void> begun;
  std::promise<void> may_end;
  servant_.on_read([&](gecos::IncomingCall call) {
    begun.set_value();
    may_end.get_future().wait();
    call.finish({});
  });
  auto added = std::async(std::launch::async, [this] { return add_probe(); });
  ASSERT_TRUE(settles([this] { return broker_.asked() == 1; }));
  const auto probe = connect();
  const auto read = probe.read();
  begun.get_future().wait();
  broker_.answer();
  EXPECT_EQ(added.wait_for(std::chrono::milliseconds(100)), std::future_status::timeout)
      << "the program may destroy the servant";
  may_end.set_value();
  EXPECT_FALSE(added.get());
}

TEST_F(Named, TheBrokerIsToldWhomTheProgramAdmits) {
  serve(Answer::Settled);
  EXPECT_EQ(broker_.admitted(), "users:") << "an older server says nothing";
  const auto nobody = broker_.number();
  server_.allow({"anna"});
  EXPECT_TRUE(settles([this] { return broker_.admitted() == "users: anna"; }));
  const auto anna = broker_.number();
  EXPECT_GT(anna, nobody);
  server_.allow({});
  EXPECT_TRUE(settles([this] { return broker_.admitted() == "users:"; }));
  EXPECT_GT(broker_.number(), anna);
}

TEST_F(Named, WhatIsAllowedBeforeTheFirstAnswerIsToldAfterIt) {
  server_.allow({"anna"});
  broker_.on_enlist = [this] { server_.allow({"ben"}); };
  serve(Answer::Settled);
  EXPECT_TRUE(settles([this] { return broker_.admitted() == "users: ben"; }));
}

TEST_F(Named, WhatIsAllowedBeforeALaterAnswerIsToldAfterIt) {
  serve(Answer::Settled);
  broker_.on_enlist = [this] { server_.allow({"ben"}); };
  server_.allow({"anna"});
  EXPECT_TRUE(settles([this] { return broker_.admitted() == "users: ben"; }));
}

TEST_F(Named, ALaterServerOfTheProcessTellsAListWithAGreaterNumber) {
  serve(Answer::Settled);
  std::uint64_t before = 0;
  for (const std::string user : {"anna", "ben", "carl"}) {
    before = broker_.number();
    server_.allow({user});
    ASSERT_TRUE(settles([&] { return broker_.number() > before; }));
  }
  before = broker_.number();
  probe::ProbeServant other;
  gecos::Server later(server_lab_);
  ASSERT_TRUE(later.add("OTHER", other, {.media = {gecos::media::Kind::Inproc}}));
  EXPECT_GT(broker_.number(), before)
      << "if it took the name of the first one, the list of that one would stay";
}

/// Another server, whose lab file has a list for its object.
class NamedInALabFile : public Named {
 protected:
  NamedInALabFile() { edit("users = [\"anna\", \"ben\"]"); }
  void edit(const std::string& list) const {
    std::ofstream(path_) << "[objects.LIMITED.allow]\n" << list << "\n";
    std::filesystem::permissions(path_, std::filesystem::perms(0644));
    // As if nobody had changed the file for a minute: an edit counts a moment later.
    std::filesystem::last_write_time(
        path_, std::filesystem::last_write_time(path_) - std::chrono::minutes(1));
  }
  void serve_limited() {
    serve(Answer::Settled);
    ASSERT_TRUE(limited_server_.add("LIMITED", limited_, {.media = {gecos::media::Kind::Inproc}}));
  }
  gecos::LabOptions with_file() const {
    auto options = probe::patient();
    options.lab_file = path_;
    return options;
  }

  const gecos::media::ScratchDirectory directory_;
  const std::string path_ = directory_.path() + "/lab.toml";
  probe::ProbeServant limited_;
  gecos::Lab limited_lab_{with_file()};
  gecos::Server limited_server_{limited_lab_};
};

TEST_F(NamedInALabFile, TheBrokerIsToldOnlyWhomTheFileAdmitsToo) {
  limited_server_.allow({"anna", "carl"});
  serve_limited();
  EXPECT_EQ(broker_.admitted(), "users: anna");
  limited_server_.allow({"*"});
  EXPECT_TRUE(settles([this] { return broker_.admitted() == "users: anna ben"; }));
}

TEST_F(NamedInALabFile, TheBrokerIsToldWhenAnEditChangesWhoIsAdmitted) {
  limited_server_.allow({"anna", "carl"});
  serve_limited();
  const auto before = broker_.number();
  edit("users = [\"carl\"]");
  EXPECT_TRUE(settles([this] { return broker_.admitted() == "users: carl"; }));
  EXPECT_GT(broker_.number(), before);
}

TEST_F(NamedInALabFile, TheBrokerIsToldNoMoreNamesThanItTakes) {
  std::string names;
  for (int i = 0; i < 300; ++i) names += "\"user" + std::to_string(i) + "\", ";
  edit("users = [" + names + "]");
  limited_server_.allow({"*"});
  serve_limited();
  EXPECT_EQ(broker_.users(), 256u);
}

TEST_F(NamedInALabFile, ANameThatTheFileRepeatsIsToldOnce) {
  std::string names;
  for (int i = 0; i < 300; ++i) names += "\"anna\", ";
  edit("users = [" + names + "\"ben\"]");
  limited_server_.allow({"*"});
  serve_limited();
  EXPECT_EQ(broker_.admitted(), "users: anna ben");
  edit(R"(users = ["max", "max", "ben", "cemil", "zoe", "cem", "ben"])");
  EXPECT_TRUE(settles([this] { return broker_.admitted() == "users: max ben cemil zoe cem"; }))
      << broker_.admitted();
}

TEST_F(Named, NamesThatTheBrokerRefusesAreRefused) {
  for (const std::string& name : {std::string(), std::string(257, 'a'), std::string("a\0b", 3),
                                  std::string("a\n"), std::string("\xff\xfe")}) {
    EXPECT_THROW(server_.allow({"anna", name}), std::invalid_argument) << name;
    EXPECT_THROW(server_.allow({}, {"desk", name}), std::invalid_argument) << name;
  }
  server_.allow({std::string(256, 'a'), "J\u00fcrgen"}, {"*"});
}

TEST_F(Named, MoreNamesThanTheBrokerTakesAreRefused) {
  server_.allow(std::vector<std::string>(256, "anna"), std::vector<std::string>(256, "desk"));
  EXPECT_THROW(server_.allow(std::vector<std::string>(257, "anna")), std::invalid_argument);
  EXPECT_THROW(server_.allow({}, std::vector<std::string>(257, "desk")), std::invalid_argument);
}

class WhileTheBrokerIsRestarted : public probe::NothingLeftOpen {
 protected:
  struct BrokerProcess {
    TellingBroker servant;
    gecos::Lab lab;
    std::optional<gecos::Server> server{std::in_place, lab};
    void start() {
      gecos::ObjectOptions options;
      options.well_known = true;
      options.media = {gecos::media::Kind::Inproc};
      ASSERT_TRUE(server->add("BROKER", servant, options));
    }
  };
  static bool there_is_a_broker() {
    gecos::Lab lab;
    return gecos::Server(lab).await_broker(gecos::Duration::zero()).has_value();
  }
};

TEST_F(WhileTheBrokerIsRestarted, AnObjectIsEnlistedWithTheNextOne) {
  BrokerProcess first;
  first.start();
  first.servant.keep_waiting();
  probe::ProbeServant servant;
  gecos::Lab server_lab(probe::patient());
  gecos::Server server(server_lab);
  auto added = std::async(std::launch::async, [&] {
    gecos::ObjectOptions options;
    options.media = {gecos::media::Kind::Inproc};
    return server.add("PROBE", servant, options);
  });
  ASSERT_TRUE(settles([&] { return first.servant.asked() == 1; }));
  auto ended = std::async(std::launch::async, [&] { first.server.reset(); });
  ASSERT_TRUE(settles([&] { return !there_is_a_broker(); }));
  EXPECT_EQ(added.wait_for(std::chrono::milliseconds(300)), std::future_status::timeout)
      << "it asked no second time";
  first.servant.answer();
  ended.get();
  BrokerProcess next;
  next.start();
  const auto result = added.get();
  EXPECT_TRUE(result) << result.error().text;
}

}  // namespace
