#include "gecos/broker/directory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <variant>

namespace gecos::broker {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::uint64_t ada = 1;
constexpr std::uint64_t bob = 2;
constexpr TimePoint started{std::chrono::hours(1)};
constexpr TimePoint settled = started + seconds(1);

/// Its broker runs for long.
class OldDirectory : public Directory {
 public:
  OldDirectory() : Directory(started) {}
  auto enlist(std::uint64_t session, std::uint64_t incarnation, const Entry& entry) {
    return Directory::enlist({session, incarnation, Duration::zero()}, entry,
                             started + seconds(60));
  }
  auto end_session(std::uint64_t session, TimePoint heard = started + seconds(61)) {
    return Directory::end_session(session, heard);
  }
};

Entry named(const std::string& name) {
  Entry entry;
  entry.name = name;
  entry.interface_name = "robcl::Rx90";
  entry.user = "ada";
  entry.hostname = "lab1";
  entry.pid = 4711;
  entry.boot = 7;
  return entry;
}

TEST(Directory, FindsWhatWasEnlisted) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  EXPECT_EQ(directory.look_up("RX90")->pid, 4711);
  EXPECT_EQ(directory.list().size(), 1u);
}

TEST(Directory, ASessionHasWhatItEnlistedUntilItEnds) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  EXPECT_TRUE(directory.has(ada, "RX90"));
  EXPECT_FALSE(directory.has(bob, "RX90")) << "whatever it says of itself";
  EXPECT_FALSE(directory.has(ada, "LASER"));
  directory.end_session(ada);
  EXPECT_FALSE(directory.has(ada, "RX90"));
}

TEST(Directory, NamesWhatItKnowsWhenAskedForSomethingElse) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  ASSERT_TRUE(directory.enlist(bob, 7, named("LASER")));
  const auto missing = directory.look_up("RX91");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().name, "RX91");
  EXPECT_EQ(missing.error().known, (std::vector<std::string>{"LASER", "RX90"}));
}

TEST(Directory, GivesANameToOneServerAtATime) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  Entry of_another = named("RX90");
  of_another.boot = 8;
  const auto taken = directory.enlist(bob, 8, of_another);
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().by, "a robcl::Rx90 of ada on lab1, pid 4711");
  EXPECT_TRUE(directory.enlist(ada, 7, named("RX90"))) << "its own session may say it again";
}

TEST(Directory, AServerThatLostItsSessionTakesItsNameIntoTheNextOne) {
  OldDirectory directory;
  const std::uint64_t lost = 1;
  const std::uint64_t next = 2;
  ASSERT_TRUE(directory.enlist(lost, 7, named("RX90")));
  ASSERT_TRUE(directory.enlist(next, 7, named("RX90")));
  EXPECT_TRUE(directory.end_session(lost).empty()) << "noticed late, and it has nothing any more";
  EXPECT_FALSE(directory.withdraw(lost, "RX90"));
  EXPECT_TRUE(directory.look_up("RX90"));
  EXPECT_TRUE(directory.withdraw(next, "RX90"));
}

TEST(Directory, NobodyTakesAServersNameByRepeatingWhatItSaid) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  EXPECT_FALSE(directory.enlist(bob, 8, *directory.look_up("RX90")));
  EXPECT_TRUE(directory.end_session(bob).empty());
}

TEST(Directory, RefusesASecondObjectOfTheSameSessionUnderOneName) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  Entry second = named("RX90");
  second.addresses = {"shm:/run/gecos/other.sock"};
  EXPECT_FALSE(directory.enlist(ada, 7, second));
  EXPECT_TRUE(directory.look_up("RX90")->addresses.empty()) << "the first one stays";
}

TEST(Directory, LetsOnlyWhoEnlistedItWithdrawIt) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  EXPECT_FALSE(directory.withdraw(bob, "RX90"));
  EXPECT_TRUE(directory.withdraw(ada, "RX90"));
  EXPECT_FALSE(directory.look_up("RX90"));
}

TEST(Directory, DropsWhatASessionEnlistedWhenItEnds) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  ASSERT_TRUE(directory.enlist(ada, 7, named("GRIPPER")));
  ASSERT_TRUE(directory.enlist(bob, 7, named("LASER")));
  EXPECT_EQ(directory.end_session(ada), (std::vector<std::string>{"GRIPPER", "RX90"}));
  EXPECT_TRUE(directory.look_up("LASER"));
  EXPECT_TRUE(directory.enlist(bob, 7, named("RX90")));
}

std::vector<std::string> names_of(const std::vector<Silent>& silent) {
  std::vector<std::string> names;
  for (const Silent& one : silent) names.push_back(one.entry.name);
  return names;
}

TEST(Directory, RemembersSinceWhenAServerIsSilent) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  EXPECT_TRUE(directory.silent(started + seconds(61)).empty());
  directory.end_session(ada, started + seconds(61));
  const auto silent = directory.silent(started + seconds(65));
  ASSERT_EQ(names_of(silent), std::vector<std::string>{"RX90"});
  EXPECT_EQ(silent[0].entry, named("RX90"));
  EXPECT_EQ(silent[0].since, started + seconds(61));
  EXPECT_FALSE(directory.look_up("RX90")) << "nobody may connect to it";
}

TEST(Directory, ForgetsASilentObjectWhenItsNameIsServedAgain) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  directory.end_session(ada);
  ASSERT_TRUE(directory.enlist(bob, 7, named("RX90")));
  EXPECT_TRUE(directory.silent(started + seconds(62)).empty());
  ASSERT_TRUE(directory.withdraw(bob, "RX90"));
  EXPECT_TRUE(directory.silent(started + seconds(63)).empty()) << "withdrawn in order";
}

TEST(Directory, ForgetsASilentObjectAfterAnHour) {
  OldDirectory directory;
  ASSERT_TRUE(directory.enlist(ada, 7, named("RX90")));
  directory.end_session(ada, started + seconds(61));
  EXPECT_EQ(directory.silent(started + seconds(3660)).size(), 1u);
  EXPECT_TRUE(directory.silent(started + seconds(3661)).empty());
}

TEST(Directory, OfManySilentObjectsWithFreeNamesTheOnesHeardLastAreRemembered) {
  OldDirectory directory;
  const std::size_t held = 10;  // one falls silent each second
  for (std::size_t i = 0; i <= Directory::most_silent + held; ++i) {
    ASSERT_TRUE(directory.enlist(i, 7, named("LAMP" + std::to_string(i))));
    directory.end_session(i, started + seconds(61 + i));
  }
  const auto names = names_of(directory.silent(started + seconds(400)));
  EXPECT_EQ(names.size(), Directory::most_silent + held);
  EXPECT_EQ(std::ranges::count(names, "LAMP0"), 0);
}

TEST(Directory, OfManyObjectsThatFallSilentAtOnceTheMostAreForgottenWhenTheirNamesAreFree) {
  OldDirectory directory;
  for (std::size_t i = 0; i < 1000; ++i) {
    const Entry entry = named("LAMP" + std::to_string(i));
    ASSERT_TRUE(directory.enlist(i < 3 ? bob : ada, 7, entry));
  }
  directory.end_session(bob, started + seconds(61));
  directory.end_session(ada, started + seconds(62));
  const TimePoint all_free = started + seconds(72);
  EXPECT_EQ(directory.on_tick(started + seconds(63)), started + seconds(71)) << "the first is free";
  EXPECT_EQ(directory.silent(started + seconds(63)).size(), 1000u) << "their names are held";
  directory.on_tick(all_free);
  const auto names = names_of(directory.silent(all_free));
  EXPECT_EQ(names.size(), Directory::most_silent);
  for (const char* early : {"LAMP0", "LAMP1", "LAMP2"})
    EXPECT_EQ(std::ranges::count(names, early), 0);
  const auto changes = directory.changes({0, 2000}, all_free).changed;
  EXPECT_EQ(changes.size(), 1000 - Directory::most_silent) << "each is told as gone";
}

Entry of_life(std::uint64_t boot, std::int32_t pid = 4711) {
  Entry entry = named("RX90");
  entry.boot = boot;
  entry.pid = pid;
  return entry;
}

/// RX90 of a server that the broker has not heard since `heard`.
class SilentServer : public ::testing::Test {
 protected:
  void fall_silent(Host host) {
    ASSERT_TRUE(directory_.enlist({1, 7, {}, host}, of_life(7), started + seconds(60)));
    directory_.end_session(1, heard);
  }
  auto enlist(std::uint64_t life, TimePoint now) {
    return directory_.enlist({life, life, {}, Host::Other}, of_life(life, 4712), now);
  }
  static constexpr TimePoint heard = started + seconds(70);
  Directory directory_{started};
};

TEST_F(SilentServer, OfAnotherHostKeepsItsNameForTenSeconds) {
  fall_silent(Host::Other);
  const auto early = enlist(8, heard + milliseconds(9999));
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error().by,
            "a robcl::Rx90 of ada on lab1, pid 4711, which has been silent for 10.0 s; the name is "
            "free in 0.0 s, or after `gecos free RX90`");
  const auto free_in = [&](TimePoint now) {
    return directory_.free_in(directory_.silent(now).at(0), now);
  };
  EXPECT_EQ(free_in(heard + milliseconds(9999)), milliseconds(1));
  EXPECT_EQ(free_in(heard + seconds(11)), Duration::zero());
  EXPECT_TRUE(enlist(8, heard + seconds(10)));
  EXPECT_TRUE(directory_.silent(heard + seconds(10)).empty());
}

TEST_F(SilentServer, KeepsItsNameForTheTimeOfTheSetting) {
  directory_ = Directory(started, {.name_hold = seconds(3)});
  fall_silent(Host::Other);
  EXPECT_FALSE(enlist(8, heard + milliseconds(2999)));
  EXPECT_TRUE(enlist(8, heard + seconds(3)));
}

TEST_F(SilentServer, KeepsItsNameForEverIfTheSettingHasNoEnd) {
  directory_ = Directory(started, {.name_hold = Duration::max()});
  fall_silent(Host::Other);
  const TimePoint late = heard + std::chrono::hours(99'999);
  EXPECT_EQ(directory_.on_tick(late), TimePoint::max());
  const auto refused = enlist(8, late);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().by.find("s; the name is free after `gecos free RX90`"),
            std::string::npos)
      << refused.error().by;
  EXPECT_TRUE(directory_.free("RX90"));
  EXPECT_TRUE(enlist(8, late));
}

TEST_F(SilentServer, OfTheBrokersHostKeepsItsNameUntilItsProcessEnds) {
  fall_silent(Host::Same);
  const auto refused = enlist(8, heard + std::chrono::hours(99));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().by.find("its process still lives on the broker's host"),
            std::string::npos);
  const auto silent = directory_.silent(heard + std::chrono::hours(99));
  ASSERT_EQ(silent.size(), 1u);
  EXPECT_EQ(directory_.free_in(silent[0], heard + std::chrono::hours(99)), std::nullopt);
  EXPECT_EQ(directory_.process_ended(4711), std::vector<std::string>{"RX90"});
  EXPECT_TRUE(enlist(8, heard + seconds(2)));
}

TEST_F(SilentServer, TakesItsNameBack) {
  for (const Host host : {Host::Same, Host::Other}) {
    directory_ = Directory(started);
    fall_silent(host);
    EXPECT_TRUE(directory_.enlist({2, 7, {}, host}, of_life(7), heard + seconds(5)));
    EXPECT_TRUE(directory_.look_up("RX90"));
    EXPECT_TRUE(directory_.silent(heard + seconds(5)).empty());
  }
}

TEST_F(SilentServer, KeepsItsNameFromAnotherUserWhoNamesItsLife) {
  for (const Host host : {Host::Same, Host::Other}) {
    directory_ = Directory(started);
    fall_silent(host);
    Entry user = of_life(7);
    user.user = "mallory";
    EXPECT_FALSE(directory_.enlist({2, 7, {}, host}, user, heard + seconds(5)));
    Entry elsewhere = of_life(7);
    elsewhere.hostname = "desk";
    EXPECT_FALSE(directory_.enlist({2, 7, {}, host}, elsewhere, heard + seconds(5)));
  }
}

TEST_F(SilentServer, KeepsItsNameAsLongAsNoOtherServerGetsIt) {
  fall_silent(Host::Other);
  EXPECT_TRUE(directory_.keeps_name("RX90", heard + milliseconds(9999)));
  EXPECT_FALSE(directory_.keeps_name("RX90", heard + seconds(10)));
  EXPECT_FALSE(directory_.keeps_name("LASER", heard));
  ASSERT_TRUE(enlist(8, heard + seconds(10)));
  EXPECT_TRUE(directory_.keeps_name("RX90", heard + seconds(99)));
}

TEST_F(SilentServer, OfAnotherHostIsSetFreeOnRequest) {
  fall_silent(Host::Other);
  EXPECT_TRUE(directory_.free("RX90"));
  EXPECT_TRUE(enlist(8, heard + seconds(2)));
}

TEST_F(SilentServer, OfTheBrokersHostIsNotSetFree) {
  fall_silent(Host::Same);
  const auto refused = directory_.free("RX90");
  ASSERT_FALSE(refused);
  const auto* why = std::get_if<NameInUse>(&refused.error());
  ASSERT_NE(why, nullptr);
  EXPECT_EQ(
      why->why,
      "the server process of this object, a robcl::Rx90 of ada on lab1, pid 4711, still lives on "
      "the broker's host and may move the device again; end it with `kill -KILL 4711`, which "
      "frees the name at once");
}

TEST_F(SilentServer, CannotBeSetFreeWhileItIsHeardOrUnknown) {
  ASSERT_TRUE(enlist(8, started + seconds(60)));
  const auto heard_of = directory_.free("RX90");
  ASSERT_FALSE(heard_of);
  EXPECT_TRUE(std::holds_alternative<NameInUse>(heard_of.error()));
  EXPECT_TRUE(std::holds_alternative<UnknownName>(directory_.free("RX91").error()));
}

/// RX90 was registered with the broker before this one, and its process lives on this host.
class ExpectedServer : public ::testing::Test {
 protected:
  ExpectedServer() { directory_.expect(of_life(7)); }
  auto enlist(std::uint64_t life, TimePoint now) {
    return directory_.enlist({life, life, seconds(5), Host::Same}, of_life(life, 4710), now);
  }
  std::vector<Presence> told(TimePoint now) const {
    std::vector<Presence> all;
    for (const auto& one : directory_.changes({9, 0}, now).changed) all.push_back(one.presence);
    return all;
  }
  static constexpr TimePoint back_by = started + Directory::servers_return_within;
  Directory directory_{started, {.life = 9}};
};

TEST_F(ExpectedServer, KeepsItsNameUntilItsProcessEnds) {
  for (const TimePoint now : {started, started + seconds(1), started + std::chrono::hours(99)}) {
    directory_.on_tick(now);
    const auto refused = enlist(8, now);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().by.find("its process still lives on the broker's host"),
              std::string::npos);
    EXPECT_FALSE(directory_.free("RX90"));
  }
  EXPECT_EQ(directory_.process_ended(4711), std::vector<std::string>{"RX90"});
  EXPECT_TRUE(enlist(8, started + std::chrono::hours(99)));
}

TEST_F(ExpectedServer, IsSilentWhenItDoesNotReturnInTime) {
  EXPECT_EQ(directory_.on_tick(started), settled);
  EXPECT_EQ(directory_.on_tick(settled), back_by);
  EXPECT_TRUE(directory_.silent(started).empty());
  EXPECT_TRUE(directory_.changes({}, started).changed.empty()) << "of the whole list, too";
  directory_.on_tick(back_by);
  EXPECT_EQ(names_of(directory_.silent(back_by)), std::vector<std::string>{"RX90"});
  EXPECT_EQ(told(back_by), std::vector<Presence>{Presence::SILENT});
  directory_.on_tick(back_by + seconds(1));
  EXPECT_EQ(told(back_by).size(), 1u) << "told once";
}

TEST_F(ExpectedServer, IsNeverCalledSilentWhenItReturnsInTime) {
  EXPECT_TRUE(directory_.enlist({1, 7, seconds(5), Host::Same}, of_life(7), started + seconds(1)));
  directory_.on_tick(back_by);
  EXPECT_EQ(told(back_by), std::vector<Presence>{Presence::ONLINE});
}

TEST_F(ExpectedServer, IsKnownToTheNextBroker) {
  EXPECT_EQ(directory_.of_this_host(started), std::vector<Entry>{of_life(7)});
  ASSERT_TRUE(directory_.enlist({1, 7, {}, Host::Same}, of_life(7), started));
  ASSERT_TRUE(directory_.enlist({2, 7, {}, Host::Other}, named("LAMP"), started));
  EXPECT_EQ(directory_.of_this_host(started), std::vector<Entry>{of_life(7)});
  directory_.end_session(1, started);
  EXPECT_EQ(directory_.of_this_host(started), std::vector<Entry>{of_life(7)});
  directory_.process_ended(4711);
  EXPECT_TRUE(directory_.of_this_host(started).empty());
}

TEST(Directory, TheNextBrokerKeepsNoNameThatIsStillProvisional) {
  Directory directory(started);
  const TimePoint young = started + milliseconds(300);
  ASSERT_TRUE(directory.enlist({1, 7, {}, Host::Same}, of_life(7), young));
  EXPECT_TRUE(directory.of_this_host(young).empty());
  directory.end_session(1, young);
  EXPECT_TRUE(directory.of_this_host(young).empty());
  EXPECT_EQ(directory.on_tick(young), settled);
  EXPECT_EQ(directory.of_this_host(settled), std::vector<Entry>{of_life(7)})
      << "although its server has not asked again";
}

TEST(Directory, TheNextBrokerKeepsANameThatABrokerBeforeHasConfirmed) {
  Directory directory(started);
  ASSERT_TRUE(directory.enlist({1, 7, {}, Host::Same, seconds(2)}, of_life(7), started));
  directory.end_session(1, started);
  EXPECT_EQ(directory.of_this_host(started), std::vector<Entry>{of_life(7)});
}

TEST(Directory, ADeathThatTheKernelReportsFreesTheNameOfALiveSession) {
  Directory directory(started);
  ASSERT_TRUE(directory.enlist({1, 7, {}, Host::Same}, of_life(7), started + seconds(60)));
  EXPECT_TRUE(directory.process_ended(4712).empty());
  directory.process_ended(4711);
  EXPECT_TRUE(directory.enlist({2, 8, {}, Host::Same}, of_life(8), started + seconds(60)));
  EXPECT_TRUE(directory.end_session(1, started + seconds(60)).empty());
}

TEST(Directory, AProcessOfAnotherHostDoesNotEndWithOneOfTheSameNumberHere) {
  Directory directory(started);
  ASSERT_TRUE(directory.enlist({1, 7, {}, Host::Other}, of_life(7), started + seconds(60)));
  EXPECT_TRUE(directory.process_ended(4711).empty());
  EXPECT_TRUE(directory.look_up("RX90"));
}

TEST(Directory, AQueryByABaseInterfaceFindsDerivedOnes) {
  OldDirectory directory;
  Entry arm = named("RX90");
  arm.bases = {"robcl::Manipulator", "robcl::Device"};
  Entry lamp = named("LAMP");
  lamp.interface_name = "robcl::Device";
  ASSERT_TRUE(directory.enlist(ada, 7, arm));
  ASSERT_TRUE(directory.enlist(ada, 7, lamp));
  const auto names = [&](std::string_view interface_name) {
    std::vector<std::string> found;
    for (const Entry& one : directory.query(interface_name)) found.push_back(one.name);
    return found;
  };
  EXPECT_EQ(names("robcl::Device"), (std::vector<std::string>{"LAMP", "RX90"}));
  EXPECT_EQ(names("robcl::Manipulator"), std::vector<std::string>{"RX90"});
  EXPECT_EQ(names("robcl::Rx90"), std::vector<std::string>{"RX90"});
  EXPECT_TRUE(names("robcl::Mani").empty());
}

TEST(Directory, GivesEachHolderOfANameAHigherEpoch) {
  Directory directory(started, {.life = 5});
  const auto epoch = [&] {
    return directory.changes({}, started + seconds(61)).changed.front().epoch;
  };
  ASSERT_TRUE(directory.enlist({1, 7, {}, Host::Other}, of_life(7), started + seconds(60)));
  const auto first = epoch();
  directory.end_session(1, started + seconds(60));
  ASSERT_TRUE(directory.enlist({2, 7, {}, Host::Other}, of_life(7), started + seconds(61)));
  EXPECT_EQ(epoch(), first) << "the same life of the server";
  ASSERT_TRUE(directory.withdraw(2, "RX90"));
  ASSERT_TRUE(directory.enlist({3, 8, {}, Host::Other}, of_life(8), started + seconds(61)));
  EXPECT_GT(epoch(), first);
}

TEST(Directory, TellsAWatcherThatIsTooFarBehindTheWholeList) {
  Directory directory(started, {.life = 5});
  const TimePoint now = started + seconds(60);
  const auto changes = [&](std::uint64_t life, std::uint64_t number) {
    return directory.changes({life, number}, now);
  };
  for (std::size_t i = 0; i < Directory::most_changes / 2; ++i) {
    ASSERT_TRUE(directory.enlist({1, 7, {}, Host::Other}, of_life(7), now));
    ASSERT_TRUE(directory.withdraw(1, "RX90"));
  }
  EXPECT_FALSE(changes(5, 0).whole);
  EXPECT_EQ(changes(5, 0).changed.size(), Directory::most_changes);
  ASSERT_TRUE(directory.enlist({1, 7, {}, Host::Other}, of_life(7), now));
  EXPECT_TRUE(changes(5, 0).whole);
  EXPECT_EQ(changes(5, 0).changed.size(), 1u);
  EXPECT_FALSE(changes(5, 1).whole);
  EXPECT_TRUE(changes(5, 1025).changed.empty());
  EXPECT_TRUE(changes(5, 1026).whole) << "a number that this broker has not reached";
  EXPECT_TRUE(changes(4, 1025).whole) << "a revision of another broker";
}

class YoungDirectory : public ::testing::Test {
 protected:
  /// What the server of that life is told which has served RX90 for so long, `after` its start.
  tl::expected<Duration, NameTaken> enlist(std::uint64_t incarnation, Duration served_for,
                                           Duration after,
                                           std::optional<Duration> confirmed_ago = {}) {
    Entry entry = named("RX90");
    entry.boot = incarnation;
    return directory_.enlist({incarnation, incarnation, served_for, Host::Other, confirmed_ago},
                             entry, started + after);
  }
  std::uint64_t holder() const { return directory_.look_up("RX90")->boot; }

  Directory directory_{started};
};

TEST_F(YoungDirectory, SaysHowLongItsAnswersAreProvisional) {
  EXPECT_EQ(enlist(7, seconds(0), milliseconds(300)), milliseconds(700));
  EXPECT_EQ(enlist(7, milliseconds(699), milliseconds(999)), milliseconds(1));
  EXPECT_EQ(enlist(7, milliseconds(700), seconds(1)), seconds(0));
  EXPECT_EQ(enlist(7, seconds(9), seconds(10)), seconds(0));
}

TEST_F(YoungDirectory, GivesANewObjectsNameToOneThatWasServedBeforeItStarted) {
  ASSERT_TRUE(enlist(7, seconds(0), milliseconds(100)));
  EXPECT_EQ(enlist(8, seconds(5), milliseconds(999)), milliseconds(1));
  EXPECT_EQ(holder(), 8u);
  EXPECT_FALSE(enlist(7, milliseconds(900), seconds(1)));
}

TEST_F(YoungDirectory, PrefersTheObjectThatHasBeenServedLongest) {
  ASSERT_TRUE(enlist(7, seconds(5), milliseconds(100)));
  EXPECT_FALSE(enlist(8, seconds(3), milliseconds(200)));
  EXPECT_TRUE(enlist(9, seconds(100), milliseconds(300)));
  EXPECT_EQ(holder(), 9u);
  EXPECT_FALSE(enlist(7, milliseconds(5300), milliseconds(400)));
}

TEST_F(YoungDirectory, PrefersTheServerForWhichABrokerHadTheNameLast) {
  ASSERT_TRUE(enlist(7, seconds(100), milliseconds(100), seconds(12)));
  EXPECT_TRUE(enlist(8, seconds(5), milliseconds(200), seconds(1)));
  EXPECT_EQ(holder(), 8u);
  EXPECT_FALSE(enlist(9, seconds(50), milliseconds(300), seconds(11)));
  EXPECT_FALSE(enlist(7, seconds(100), milliseconds(400), seconds(0))) << "it gave way before";
}

TEST_F(YoungDirectory, PrefersAServerForWhichABrokerHadTheNameToOneForWhichNoneHad) {
  ASSERT_TRUE(enlist(7, seconds(100), milliseconds(100)));
  EXPECT_TRUE(enlist(8, seconds(5), milliseconds(200), seconds(1)));
  EXPECT_FALSE(enlist(9, seconds(200), milliseconds(300)));
  EXPECT_EQ(holder(), 8u);
}

TEST_F(YoungDirectory, AConfirmationThatItsServerDoesNotRepeatCountsNoMore) {
  ASSERT_TRUE(enlist(7, seconds(100), milliseconds(100), seconds(1)));
  ASSERT_TRUE(enlist(7, seconds(100), milliseconds(200)));
  EXPECT_TRUE(enlist(8, seconds(5), milliseconds(300), seconds(3)));
}

TEST_F(YoungDirectory, OfTwoNewObjectsTheFirstKeepsTheName) {
  ASSERT_TRUE(enlist(7, seconds(0), milliseconds(200)));
  EXPECT_FALSE(enlist(8, milliseconds(150), milliseconds(250)))
      << "served earlier, but not before the broker started";
}

TEST_F(YoungDirectory, AfterItsFirstSecondANameStaysWhereItIs) {
  ASSERT_TRUE(enlist(7, seconds(0), milliseconds(100)));
  EXPECT_FALSE(enlist(8, seconds(100), seconds(1)));
  EXPECT_EQ(holder(), 7u);
}

TEST_F(YoungDirectory, AnObjectThatGaveWayDoesNotComeBackWithABetterAge) {
  ASSERT_TRUE(enlist(7, seconds(5), milliseconds(100)));  // a packet that was long under way
  ASSERT_TRUE(enlist(8, seconds(6), milliseconds(200)));
  EXPECT_FALSE(enlist(7, seconds(9), milliseconds(300)));
  EXPECT_EQ(holder(), 8u);
}

TEST_F(YoungDirectory, TheEndOfTheSessionThatGaveWayTakesNothingOff) {
  ASSERT_TRUE(enlist(7, seconds(0), milliseconds(100)));
  ASSERT_TRUE(enlist(8, seconds(5), milliseconds(200)));
  EXPECT_TRUE(directory_.end_session(7, started).empty());
  EXPECT_EQ(holder(), 8u);
}

}  // namespace
}  // namespace gecos::broker
