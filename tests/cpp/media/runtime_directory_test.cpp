// Where the programs of a user meet: the directory, and what may stand at a well-known place in it.

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <filesystem>
#include <fstream>

#include "child_process.hpp"
#include "gecos/media/kinds.hpp"
#include "gecos/media/shm/shm.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

TEST(RuntimeDirectory, IsMadeForThisUserAlone) {
  const ScratchDirectory scratch;
  const std::string path = scratch.path() + "/gecos";
  ASSERT_TRUE(shm::prepare_directory(path));
  struct stat made {};
  ASSERT_EQ(::stat(path.c_str(), &made), 0);
  EXPECT_EQ(made.st_mode & 0777, 0700u);
  EXPECT_TRUE(shm::prepare_directory(path)) << "and found again";
}

TEST(RuntimeDirectory, IsRefusedWhereOthersCouldListenIn) {
  const ScratchDirectory scratch;
  ASSERT_EQ(::chmod(scratch.path().c_str(), 0777), 0);
  const auto refused = shm::prepare_directory(scratch.path());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text, "shm: other users may write to " + scratch.path() +
                                      " and could listen in; run:  chmod go-w " + scratch.path());
  const auto file = scratch.path() + "/file";
  std::filesystem::copy("/proc/self/comm", file);
  EXPECT_FALSE(shm::prepare_directory(file));
  EXPECT_FALSE(shm::prepare_directory(scratch.path() + "/not/there"));
  const auto link = scratch.path() + "/link";
  std::filesystem::create_directory_symlink("/", link);
  EXPECT_FALSE(shm::prepare_directory(link)) << "in /tmp somebody else may have made the link";
}

TEST(RuntimeDirectory, IsIdentifiedOnItsMachine) {
  const ScratchDirectory one;
  const ScratchDirectory two;
  const auto first = shm::directory_identity(one.path());
  ASSERT_TRUE(first);
  EXPECT_EQ(*first, shm::directory_identity(one.path()));
  EXPECT_NE(*first, shm::directory_identity(two.path()));
  EXPECT_EQ(shm::kernel_boot().size(), 36u);
}

TEST(RuntimeDirectory, HasAPathOfFiftyCharactersAtTheMost) {
  const ScratchDirectory scratch;
  const std::string longest = scratch.path() + "/" + std::string(49 - scratch.path().size(), 'x');
  ASSERT_EQ(longest.size(), 50u);
  const auto acceptor = make_shm({.directory = longest})->listen(std::string(99, 'n'), false);
  EXPECT_TRUE(acceptor) << acceptor.error().text;
  const auto refused = shm::prepare_directory(longest + "x");
  ASSERT_FALSE(refused);
  EXPECT_EQ(
      refused.error().text,
      "shm: the path " + longest +
          "x has 51 characters, but sockets need a directory whose path has at most 50; name a "
          "shorter directory in GECOS_RUNTIME_DIR");
  EXPECT_FALSE(make_shm({.directory = longest + "x"})->listen("RX90", false));
}

/// GECOS_RUNTIME_DIR while it lives.
class Named {
 public:
  explicit Named(const std::string& directory) {
    if (const char* set = ::getenv(variable)) before_ = set;
    ::setenv(variable, directory.c_str(), 1);
  }
  ~Named() { before_.empty() ? ::unsetenv(variable) : ::setenv(variable, before_.c_str(), 1); }

 private:
  static constexpr const char* variable = "GECOS_RUNTIME_DIR";
  std::string before_;
};

std::string own_folder(const std::string& in) {
  return in + "/gecos-" + std::to_string(::geteuid());
}

TEST(RuntimeDirectory, IsAFolderOfThisUsersOwnWhereAllUsersShareTheOneNamed) {
  const Named tmp("/tmp/");
  EXPECT_EQ(shm::default_runtime_directory(), own_folder("/tmp"));
  const ScratchDirectory scratch;
  const Named own(scratch.path() + "/");
  EXPECT_EQ(shm::default_runtime_directory(), scratch.path());
}

TEST(RuntimeDirectory, ThatCannotBeUsedIsNamedToWhoOpensTheMedium) {
  const ScratchDirectory scratch;
  ASSERT_EQ(::chmod(scratch.path().c_str(), 0777), 0);
  const Named open_to_all(scratch.path());
  const auto opened = open(Kind::Shm);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().text.find("chmod go-w " + scratch.path()), std::string::npos)
      << opened.error().text;
}

// Several users

constexpr uid_t ada = 20'001;
constexpr uid_t bob = 20'002;

void become(uid_t user) {
  if (::setgid(user) != 0 || ::setuid(user) != 0) throw std::runtime_error("setuid");
}

/// The broker's place of `user`, served until the test ends.
ChildProcess broker_of(uid_t user) {
  return ChildProcess([user](const auto& say_ready) {
    become(user);
    const auto acceptor = make_shm()->listen("BROKER", true);
    if (!acceptor) return;
    say_ready();
    for (;;) {
      End client(wait_for_client(**acceptor));
      if (client.receive() == "who?") static_cast<void>(client.send(std::to_string(user)));
    }
  });
}

/// What a program of `user` hears at its broker's place, or why it hears nothing.
std::string heard_by(uid_t user) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  ChildProcess asking([&](const auto&) {
    become(user);
    const auto medium = make_shm();
    auto connection = medium->connect(medium->well_known_address("BROKER"));
    std::string said = connection ? "" : connection.error().text;
    if (connection) {
      End end(std::move(*connection));
      static_cast<void>(end.send("who?"));
      said = end.receive();
    }
    static_cast<void>(!::write(ends[1], said.data(), said.size()));
  });
  EXPECT_EQ(asking.wait(), 0);
  ::close(ends[1]);
  std::string said(4096, '\0');
  said.resize(static_cast<std::size_t>(std::max<ssize_t>(::read(ends[0], said.data(), 4096), 0)));
  ::close(ends[0]);
  return said;
}

TEST(TwoUsers, EachHaveABrokerOfTheirOwnInADirectoryThatRootMadeForAll) {
  if (::geteuid() != 0) GTEST_SKIP() << "NOT TRIED: two users are needed; run this test as root";
  const ScratchDirectory scratch;
  ASSERT_EQ(::chmod(scratch.path().c_str(), 01777), 0);
  const Named shared(scratch.path());
  const ChildProcess first = broker_of(ada);
  ASSERT_TRUE(first.wait_ready());
  const std::string alone = heard_by(bob);
  EXPECT_NE(alone.find("no server listens at this address (only servers of uid 20002 are in the "
                       "directory of this address; use GECOS_BROKER=lcm to reach programs of other "
                       "users)"),
            std::string::npos)
      << alone;
  const ChildProcess second = broker_of(bob);
  ASSERT_TRUE(second.wait_ready()) << "who comes first does not keep the others out";
  EXPECT_EQ(heard_by(ada), "20001");
  EXPECT_EQ(heard_by(bob), "20002");
}

TEST(TwoUsers, NobodyIsToldToEndTheProgramOfAnother) {
  if (::geteuid() != 0) GTEST_SKIP() << "NOT TRIED: two users are needed; run this test as root";
  const ScratchDirectory scratch;
  ASSERT_EQ(::chown(scratch.path().c_str(), ada, ada), 0);
  const Named adas(scratch.path());
  const ChildProcess broker = broker_of(ada);
  ASSERT_TRUE(broker.wait_ready());
  const auto said = heard_by(bob);
  EXPECT_NE(
      said.find("the socket belongs to another user, whose programs are reached over lcm only"),
      std::string::npos)
      << said;
  ASSERT_EQ(::chown(scratch.path().c_str(), 0, 0), 0);
  const auto second = make_shm()->listen("BROKER", true);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().text.find("is served already by uid 20001, pid " +
                                     std::to_string(broker.pid()) + ", a program of another user"),
            std::string::npos)
      << second.error().text;
  EXPECT_EQ(second.error().text.find("kill"), std::string::npos) << second.error().text;
}

TEST(TwoUsers, AServerOfAnotherUserIsNotTakenForOnesOwn) {
  if (::geteuid() != 0) GTEST_SKIP() << "NOT TRIED: two users are needed; run this test as root";
  const ScratchDirectory scratch;
  ASSERT_EQ(::chmod(scratch.path().c_str(), 01777), 0);
  const Named shared(scratch.path());
  const ChildProcess impostor = broker_of(ada);
  ASSERT_TRUE(impostor.wait_ready());
  const std::string adas = scratch.path() + "/gecos-20001";
  ASSERT_EQ(::chmod(adas.c_str(), 0777), 0);
  ASSERT_EQ(::chmod((adas + "/BROKER.sock").c_str(), 0666), 0);
  ASSERT_EQ(::symlink(adas.c_str(), (scratch.path() + "/gecos-20002").c_str()), 0);
  ASSERT_EQ(::lchown((scratch.path() + "/gecos-20002").c_str(), bob, bob), 0);
  const std::string said = heard_by(bob);
  EXPECT_NE(said.find("the server runs as another user, uid 20001"), std::string::npos) << said;
}

TEST(RuntimeDirectory, IsOpenToAllUsersOnlyIfItIsThatOfRootWhereAnAdministratorMadeOne) {
  if (::geteuid() != 0) GTEST_SKIP() << "NOT TRIED: this is about root; run this test as root";
  EXPECT_FALSE(shm::open_to_all_users("/tmp/gecos-0")) << "every system has /tmp";
  const ScratchDirectory scratch;
  EXPECT_FALSE(shm::open_to_all_users(scratch.path() + "/gecos-0")) << "not made for all users";
  ASSERT_EQ(::chmod(scratch.path().c_str(), 01777), 0);
  EXPECT_TRUE(shm::open_to_all_users(scratch.path() + "/gecos-0"));
  EXPECT_FALSE(shm::open_to_all_users(scratch.path() + "/gecos-20001"));
  EXPECT_FALSE(shm::open_to_all_users(scratch.path()));
}

// What stands at a well-known place

TEST(WellKnownPlace, ThatIsALinkToNothingOrAFileIsNotTakenForAServer) {
  const ScratchDirectory scratch;
  const auto medium = make_shm({.directory = scratch.path()});
  const std::string place = scratch.path() + "/RX90.sock";
  const std::string expected = "shm: " + place +
                               " exists, but is not the socket of a server; remove it, or "
                               "name a directory of your own in GECOS_RUNTIME_DIR";
  std::filesystem::create_symlink(scratch.path() + "/gone", place);
  const auto dangling = medium->listen("RX90", true);
  ASSERT_FALSE(dangling);
  EXPECT_EQ(dangling.error().text, expected);
  std::filesystem::remove(place);
  std::ofstream(place) << "not ours";
  const auto file = medium->listen("RX90", true);
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().text, expected);
  EXPECT_TRUE(std::filesystem::exists(place)) << "what is not ours is not removed";
  std::filesystem::remove(place);
  EXPECT_TRUE(medium->listen("RX90", true));
}

}  // namespace
}  // namespace gecos::media
