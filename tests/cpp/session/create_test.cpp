#include <sys/wait.h>
#include <unistd.h>

#include <future>

#include "bench.hpp"
#include "gecos/base/pid_namespace.hpp"
#include "gecos/binding.hpp"
#include "gecos/session/client/broker_client.hpp"
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/select.hpp"

namespace {

using gecos::Detail;
using gecos::media::Kind;
using gecos::session::LabAccess;

class Create : public probe::Bench {
 protected:
  gecos::CreateError attempts(const std::vector<std::string>& names,
                              gecos::CreateOptions options = {}) {
    auto created = lab_.create<probe::Probe>(names, options);
    EXPECT_FALSE(created);
    return created ? gecos::CreateError{} : created.error();
  }
};

TEST_F(Create, TakesTheFirstThatIsThereAndSaysWhyNotTheOthers) {
  serve("SIM", servant_);
  auto created =
      gecos::session::create(LabAccess::context(lab_), probe::description(), {"REAL", "SIM"}, {});
  ASSERT_TRUE(created) << created.error();
  EXPECT_EQ(created->session->object_name(), "SIM");
  ASSERT_EQ(created->passed_over.attempts.size(), 1u);
  EXPECT_EQ(created->passed_over.attempts[0].name, "REAL");
  EXPECT_EQ(created->passed_over.attempts[0].reason,
            "no object is called REAL; start the object's server, or choose a name that the broker "
            "knows: SIM");
}

TEST_F(Create, WaitsForAnObjectThatComesOnline) {
  auto created = std::async(std::launch::async, [&] {
    return lab_.create<probe::Probe>({"LATE", "LATER"}, {.wait = std::chrono::minutes(5)});
  });
  EXPECT_EQ(created.wait_for(std::chrono::milliseconds(300)), std::future_status::timeout);
  serve("LATER", servant_);
  const auto late = created.get();
  ASSERT_TRUE(late) << late.error();
  EXPECT_EQ(session_of(*late)->object_name(), "LATER");
}

TEST_F(Create, DoesNotWaitForAnObjectOfAnotherType) {
  serve("PROBE", servant_);
  static constexpr gecos::InterfaceDescription other{.name = "test::Other"};
  const auto created = gecos::session::create(LabAccess::context(lab_), other, {"PROBE"},
                                              {.wait = std::chrono::hours(1)});
  ASSERT_FALSE(created);
  EXPECT_EQ(created.error().attempts[0].detail, Detail::Refused);
  EXPECT_FALSE(lab_.create<probe::Probe>("", {.wait = std::chrono::hours(1)})) << "a nil name";
}

TEST_F(Create, WaitsNoLongerThanTheLabIsOpen) {
  gecos::Lab lab(probe::patient());
  auto created = std::async(std::launch::async, [&] {
    return lab.create<probe::Probe>("NOBODY", {.wait = gecos::Duration::max()});
  });
  lab.close();
  EXPECT_FALSE(created.get());
}

TEST(CreateWithoutBroker, WaitsNoLongerThanAskedThoughAnotherThreadLooksLonger) {
  gecos::LabOptions options;
  options.broker = "lcm:239.255.76.67:7679/GOnobody";
  gecos::Lab lab(options);
  auto patient = std::async(std::launch::async, [&] {
    EXPECT_FALSE(lab.create<probe::Probe>("PROBE", {.patience = std::chrono::seconds(3)}));
  });
  int beside_it = 0;
  while (beside_it < 3 && patient.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    const auto begin = std::chrono::steady_clock::now();
    const auto created =
        lab.create<probe::Probe>("PROBE", {.patience = std::chrono::milliseconds(100)});
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
    ASSERT_FALSE(created);
    const std::string why = created.error().to_string();
    if (why.find("another thread of this program is looking") != std::string::npos) ++beside_it;
  }
  EXPECT_EQ(beside_it, 3);
}

TEST_F(Create, NamesBothTypesWhenTheObjectIsOfAnother) {
  serve("PROBE", servant_);
  auto created = lab_.create<probe::Other>("PROBE");
  ASSERT_FALSE(created);
  EXPECT_EQ(
      created.error().to_string(),
      "PROBE: REFUSED: PROBE is a probe::Probe, not a probe::Other; create a probe::Probe, or "
      "name another object");
}

TEST_F(Create, SaysOfEachMediumWhyTheServerCannotBeReachedOverIt) {
  serve("PROBE", servant_);
  gecos::Entry entry = [&] {
    gecos::Entry dead;
    dead.name = "DEAD";
    dead.interface_name = "probe::Probe";
    dead.boot = gecos::number(gecos::session::process_incarnation());
    dead.host = LabAccess::context(lab_).value()->runtime()->host_identity() + "0";
    dead.user = "ben";
    dead.addresses = {"inproc:nowhere", "shm:/run/gecos/gecos-1000/DEAD.12.1.sock"};
    return dead;
  }();
  auto broker =
      LabAccess::context(lab_).value()->broker(gecos::deadline_after(std::chrono::seconds(5)));
  ASSERT_TRUE(broker) << broker.error().text;
  ASSERT_TRUE(
      gecos::session::await_registered(*gecos::session::register_object(**broker, entry, {}),
                                       gecos::deadline_after(std::chrono::seconds(5))));
  const auto error = attempts({"DEAD"});
  ASSERT_EQ(error.attempts.size(), 1u);
  EXPECT_EQ(error.attempts[0].detail, Detail::NoServer);
  EXPECT_EQ(error.attempts[0].reason.rfind("DEAD cannot be reached (inproc:nowhere: ", 0), 0u)
      << error;
  EXPECT_NE(error.attempts[0].reason.find(
                "; shm: the server of the object runs as ben; programs of other users "
                "reach only servers of root and of gecos over shm)"),
            std::string::npos)
      << error;
}

TEST_F(Create, FailsOverAMediumThatTheServerDoesNotOfferThoughOthersExist) {
  serve("PROBE", servant_);
  gecos::CreateOptions options;
  options.medium = Kind::Lcm;
  const auto error = attempts({"PROBE"}, options);
  ASSERT_EQ(error.attempts.size(), 1u);
  EXPECT_EQ(error.attempts[0].detail, Detail::QosUnavailable);
  EXPECT_EQ(error.attempts[0].reason,
            "PROBE cannot be reached over lcm: the server does not offer this medium; use "
            "inproc");
}

TEST_F(Create, SaysWhatItTriedWhenThereIsNoBroker) {
  gecos::LabOptions elsewhere;
  elsewhere.broker = "inproc:nobody";
  gecos::Lab lab(elsewhere);
  auto created = lab.create<probe::Probe>("PROBE");
  ASSERT_FALSE(created);
  const std::string text = created.error().to_string();
  EXPECT_NE(text.find("start `gecos up` (a laboratory on this machine) or `gecos broker`"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("tried inproc:nobody"), std::string::npos) << text;
}

TEST_F(Create, SaysWhyTheMediumThatLeadsToTheBrokerCannotBeHad) {
  setenv("GECOS_LCM_TTL", "far", 1);
  gecos::LabOptions over_lcm;
  over_lcm.broker = "lcm";
  gecos::Lab lab(over_lcm);
  const auto created = lab.create<probe::Probe>("PROBE");
  unsetenv("GECOS_LCM_TTL");
  ASSERT_FALSE(created);
  EXPECT_NE(created.error().to_string().find("GECOS_LCM_TTL is 'far'"), std::string::npos)
      << created.error();
}

TEST_F(Create, TellsAnotherRuntimeDirectoryOfThisHostFromAnotherHost) {
  auto& runtime = *LabAccess::context(lab_).value()->runtime();
  gecos::Entry entry;
  entry.hostname = "robots";
  entry.addresses = {"shm:/tmp/theirs/PROBE.12.1.sock"};
  const auto why = [&] {
    return gecos::session::Selection(runtime, entry, {}, {}, std::nullopt).why_none();
  };
  entry.host = runtime.host_identity() + "0";
  EXPECT_EQ(why(),
            "cannot be reached (shm: the object is on this host, but in another runtime directory "
            "(shm:/tmp/theirs/PROBE.12.1.sock): for shm, both programs must run as one user "
            "with the same GECOS_RUNTIME_DIR)");
  entry.user = "ben";
  EXPECT_EQ(why(),
            "cannot be reached (shm: the server of the object runs as ben; programs of other users "
            "reach only "
            "servers of root and of gecos over shm)");
  entry.host = "0" + runtime.host_identity();
  EXPECT_EQ(why(), "cannot be reached (shm: the object is on another host (robots))");
}

TEST_F(Create, RefusesHardRealtimeOnAMediumThatCannotUnlessSimulated) {
  gecos::Entry entry;
  entry.host = LabAccess::context(lab_).value()->runtime()->host_identity();
  entry.addresses = {"lcm:239.255.76.67:20017/x"};
  const gecos::qos::Quality hard{.line = gecos::qos::Class::HardRealtime};
  const auto selection = [&](bool simulated) {
    return gecos::session::Selection(*LabAccess::context(lab_).value()->runtime(), entry,
                                     gecos::session::demanded_of(hard, simulated), {},
                                     std::nullopt);
  };
  EXPECT_TRUE(selection(false).best_first().empty());
  EXPECT_EQ(selection(false).why_none(),
            "no medium meets the required quality; class=HARD_REALTIME: the medium lcm shares a "
            "queue with "
            "other programs and may lose packets");
  EXPECT_EQ(selection(true).best_first().size(), 1u);
}

TEST(Demanded, OfASimulatedDeviceIsNoLatency) {
  const gecos::qos::Quality asked{.line = gecos::qos::Class::SoftRealtime,
                                  .latency = std::chrono::milliseconds(5)};
  EXPECT_EQ(gecos::session::demanded_of(asked, false).latency, asked.latency);
  EXPECT_EQ(gecos::session::demanded_of(asked, true).latency, gecos::Duration::zero());
}

TEST_F(Create, TakesOnlyMediaThatTheInterfaceNames) {
  using gecos::qos::Media;
  gecos::ObjectOptions everything;
  everything.simulated = true;
  ASSERT_TRUE(server_->add("PROBE", servant_, everything));
  gecos::InterfaceDescription wanted = probe::description();
  const auto over = [&](Media media) {
    wanted.quality.media = media;
    return gecos::session::create(LabAccess::context(lab_), wanted, {"PROBE"}, {});
  };
  const auto medium = [](const auto& created) { return created->session->capabilities().name; };

  auto lcm = over(Media::Lcm);
  ASSERT_TRUE(lcm) << lcm.error();
  EXPECT_EQ(medium(lcm), "lcm");
  auto either = over(Media::Lcm | Media::Shm);  // inproc is shared memory, and better
  ASSERT_TRUE(either) << either.error();
  EXPECT_EQ(medium(either), "inproc");
  const auto none = over(Media::Tcp | Media::Can);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().attempts[0].detail, Detail::QosUnavailable);
  for (const char* offered : {"inproc", "shm", "lcm"}) {
    const std::string term =
        std::string("media=tcp|can: ") + offered + " is not one of these media";
    EXPECT_NE(none.error().to_string().find(term), std::string::npos) << none.error();
  }
}

TEST_F(Create, PrefersTheMediumThatPromisesMost) {
  gecos::ObjectOptions everything;
  everything.simulated = true;
  ASSERT_TRUE(server_->add("PROBE", servant_, everything));
  auto created = lab_.create<probe::Probe>("PROBE");
  ASSERT_TRUE(created) << created.error();
  EXPECT_EQ(created->session()->capabilities().name, "inproc");
  for (const Kind kind : {Kind::Inproc, Kind::Shm, Kind::Lcm}) {
    gecos::CreateOptions options;
    options.medium = kind;
    auto asked = lab_.create<probe::Probe>("PROBE", options);
    ASSERT_TRUE(asked) << asked.error();
    EXPECT_EQ(asked->session()->capabilities().name, to_string(kind));
    EXPECT_EQ(asked->read().get().value(), 7);
  }
}

TEST_F(Create, TellsWhatAnObjectIs) {
  serve("PROBE", servant_);
  const auto about = gecos::describe(connect(lab_)).get();
  ASSERT_TRUE(about) << about.error();
  EXPECT_EQ(about->name, "PROBE");
  EXPECT_EQ(about->interface_name, "probe::Probe");
  EXPECT_EQ(about->presence, "not required (simulated)");
  EXPECT_EQ(about->pid, getpid());
}

TEST_F(Create, TellsTheModelOfAnObjectOverEveryMedium) {
  gecos::ObjectOptions everything;
  everything.simulated = true;
  ASSERT_TRUE(server_->add("PROBE", servant_, everything));
  for (const Kind kind : {Kind::Inproc, Kind::Shm, Kind::Lcm}) {
    gecos::CreateOptions options;
    options.medium = kind;
    auto asked = lab_.create<probe::Probe>("PROBE", options);
    ASSERT_TRUE(asked) << asked.error();
    const std::vector<std::string> one_base_once = {"probe::Probe", "probe::Device"};
    EXPECT_EQ(gecos::model(*asked).get().value(), one_base_once);
  }
}

TEST_F(Create, IsRefusedANameThatItsOwnServerHasAlready) {
  serve("PROBE", servant_);
  probe::ProbeServant second;
  gecos::ObjectOptions options;
  options.media = {Kind::Inproc};
  const auto added = server_->add("PROBE", second, options);
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().text.find("the name PROBE is taken by"), std::string::npos)
      << added.error().text;
  EXPECT_EQ(connect(lab_).read().get().value(), 7) << "the first one goes on";
}

/// Knows of a server that has ended or is silent, and drops it when it has been asked for the name
/// `asked_before` times.
class SlowBroker : public gecos::BrokerServant {
 public:
  SlowBroker(gecos::Entry dead, int asked_before) : dead_(std::move(dead)), left_(asked_before) {}
  SlowBroker(gecos::SilentObject silent, int asked_before)
      : silent_(std::move(silent)), left_(asked_before) {}
  int left() const { return left_; }

 private:
  gecos::Result<std::optional<double>> enlist(
      const gecos::Entry& what, double /*served_for*/, const std::optional<gecos::AdmittedNames>&,
      const std::optional<double>& /*confirmed_ago*/) override {
    if (left_ == 0) return std::nullopt;
    --left_;
    return tl::unexpected(gecos::Fault(gecos::NameTaken{what.name, "one that is dead"}));
  }
  gecos::Result<void> withdraw(const std::string&) override { return {}; }
  gecos::Result<gecos::Entry> lookup(const std::string& name) override {
    if (silent_) return tl::unexpected(gecos::Fault(gecos::UnknownName{name, {}}));
    return dead_;
  }
  gecos::Result<std::vector<gecos::Entry>> list() override { return {}; }
  gecos::Result<std::vector<gecos::SilentObject>> silent() override {
    std::vector<gecos::SilentObject> objects;
    if (silent_) objects.push_back(*silent_);
    return objects;
  }
  gecos::Result<std::vector<gecos::Entry>> query(const std::string&) override { return {}; }
  gecos::Result<gecos::ListChanges> changes(const gecos::ListRevision&) override { return {}; }
  gecos::Result<gecos::RevocationList> revocations(std::uint64_t) override { return {}; }
  gecos::Result<gecos::RevocationState> behind(const std::vector<gecos::Revocation>&) override {
    return {};
  }
  gecos::Result<gecos::ListRevision> revision() override { return {}; }
  gecos::Result<void> free(const std::string&) override { return {}; }

  const gecos::Entry dead_;
  const std::optional<gecos::SilentObject> silent_;
  std::atomic<int> left_;  // publishes nothing but itself
};

/// Who had a pid, and has ended.
pid_t dead_process() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  EXPECT_EQ(waitpid(child, nullptr, 0), child);
  return child;
}

class Restarted : public probe::NothingLeftOpen {
 protected:
  /// What a server gets that asks for a name which `holder` has, until the third asking.
  template <class Holder>
  tl::expected<void, gecos::ServeError> add(Holder holder) {
    SlowBroker broker(std::move(holder), 2);
    gecos::Lab broker_lab;
    gecos::Server broker_server(broker_lab);
    gecos::ObjectOptions options;
    options.simulated = true;
    options.media = {Kind::Inproc};
    gecos::ObjectOptions well_known = options;
    well_known.well_known = true;
    const auto served = broker_server.add("BROKER", broker, well_known);
    EXPECT_TRUE(served) << served.error().text;
    gecos::Server server(lab_);
    probe::ProbeServant servant;
    auto added = server.add("PROBE", servant, options);
    asked_ = 2 - broker.left();
    return added;
  }

  gecos::Entry entry(pid_t pid) {
    gecos::Entry holder;
    holder.name = "PROBE";
    holder.host = LabAccess::context(lab_).value()->runtime()->host_identity();
    holder.pid = pid;
    holder.pid_namespace = gecos::pid_namespace();
    return holder;
  }

  gecos::Lab lab_;
  int asked_ = 0;
};

TEST_F(Restarted, AServerWaitsForItsNameUntilTheBrokerHasNoticedTheDeathOfWhoHadIt) {
  const auto added = add(entry(dead_process()));
  EXPECT_TRUE(added) << added.error().text;
  EXPECT_EQ(asked_, 2);
}

TEST_F(Restarted, AServerIsRefusedAtOnceANameWhoseHolderMayLive) {
  gecos::Entry elsewhere = entry(dead_process());
  elsewhere.host = "another host";
  gecos::Entry in_a_container = entry(dead_process());
  in_a_container.pid_namespace += 1;
  for (const auto& holder : {entry(getpid()), elsewhere, in_a_container, entry(0)}) {
    const auto added = add(holder);
    ASSERT_FALSE(added);
    EXPECT_EQ(asked_, 1) << added.error().text;
  }
}

TEST_F(Restarted, AServerIsRefusedAtOnceANameThatASilentOneKeepsForLonger) {
  for (const std::optional<double> free_in : {std::optional<double>(), std::optional(3600.0)}) {
    const auto added = add(gecos::SilentObject{entry(getpid()), 4.2, free_in});
    ASSERT_FALSE(added);
    EXPECT_EQ(asked_, 1) << added.error().text;
  }
}

TEST_F(Restarted, AServerWaitsForANameThatASilentOneLosesInTime) {
  const auto added = add(gecos::SilentObject{entry(getpid()), 4.2, 0.1});
  EXPECT_TRUE(added) << added.error().text;
  EXPECT_EQ(asked_, 2);
}

TEST_F(Create, IsRefusedANameThatAnotherServerHas) {
  serve("PROBE", servant_);
  gecos::Server second(second_lab_);
  probe::ProbeServant servant;
  gecos::ObjectOptions options;
  options.media = {Kind::Inproc};
  const auto added = second.add("PROBE", servant, options);
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().text.find("the name PROBE is taken by a probe::Probe of"),
            std::string::npos)
      << added.error().text;
}

}  // namespace
