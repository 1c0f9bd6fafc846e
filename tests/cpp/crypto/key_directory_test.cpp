#include "gecos/crypto/key_directory.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <vector>

#include "gecos/crypto/key_file.hpp"

namespace gecos::crypto {
namespace {

namespace fs = std::filesystem;

class KeyDirectoryTest : public ::testing::Test {
 protected:
  KeyDirectoryTest() {
    std::string pattern = "/tmp/gecos-keys-XXXXXX";
    root = ::mkdtemp(pattern.data());
    keys = root / "config" / "gecos" / "keys";
  }
  ~KeyDirectoryTest() override { fs::remove_all(root); }

  KeyDirectory open() { return KeyDirectory::open(keys.string()).value(); }
  std::string why_not_opened() {
    const auto opened = KeyDirectory::open(keys.string());
    return opened ? "opened" : opened.error().text;
  }
  std::string why_no_identity() {
    const auto identity = open().identity();
    return identity ? "an identity" : identity.error().text;
  }
  ::mode_t mode_of(const fs::path& path) {
    struct stat found {};
    return ::stat(path.c_str(), &found) == 0 ? found.st_mode & 07777 : 0;
  }
  fs::path secret() { return keys / "own.secret"; }
  std::string content(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write(const fs::path& path, const std::string& text) {
    std::ofstream(path) << text;
    ::chmod(path.c_str(), 0600);
  }

  fs::path root;
  fs::path keys;
};

TEST_F(KeyDirectoryTest, KeysAreMadeOnFirstUseAndAreTheSameEverAfter) {
  const auto directory = open();
  const auto first = directory.identity();
  ASSERT_TRUE(first);
  const auto second = open().identity();
  ASSERT_TRUE(second);
  EXPECT_EQ(first->public_key(), second->public_key());
  EXPECT_TRUE(std::ranges::equal(first->secret(), second->secret()));
}

TEST_F(KeyDirectoryTest, FilesAndDirectoriesAreTheUsersAlone) {
  const ::mode_t before = ::umask(0);
  const auto identity = open().identity();
  ::umask(before);
  ASSERT_TRUE(identity);
  EXPECT_EQ(mode_of(keys), 0700U);
  EXPECT_EQ(mode_of(keys.parent_path()), 0700U);
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(keys)) {
    names.insert(entry.path().filename().string());
    EXPECT_EQ(mode_of(entry.path()), 0600U) << entry.path();
  }
  EXPECT_EQ(names,
            (std::set<std::string>{"own.secret", identity->public_key().to_string() + ".public"}));
}

TEST_F(KeyDirectoryTest, OwnKeysAreAdmittedAndStrangersAreNot) {
  const auto directory = open();
  const auto identity = directory.identity();
  EXPECT_TRUE(directory.is_admitted(identity->public_key()));
  EXPECT_FALSE(directory.is_admitted(KeyPair::draw().public_key));
}

TEST_F(KeyDirectoryTest, AColleaguesPublicFileAdmitsUntilItIsRemoved) {
  const auto directory = open();
  const auto colleague = KeyDirectory::open((root / "colleague").string()).value();
  const PublicKey theirs = colleague.identity()->public_key();
  const std::string name = theirs.to_string() + ".public";
  fs::copy_file(root / "colleague" / name, keys / name);
  ::chmod((keys / name).c_str(), 0644);  // as copying tools leave it
  EXPECT_TRUE(directory.is_admitted(theirs));
  fs::remove(keys / name);
  EXPECT_FALSE(directory.is_admitted(theirs));
}

TEST_F(KeyDirectoryTest, APublicFileThatIsNotWhatItSaysAdmitsNobody) {
  const auto directory = open();
  const PublicKey own = directory.identity()->public_key();
  const std::string right = content(keys / (own.to_string() + ".public"));
  const PublicKey other = KeyPair::draw().public_key;
  const fs::path others = keys / (other.to_string() + ".public");
  const auto why = [&] { return directory.admission(other).error().text; };
  const std::string refused = "the key " + other.short_name() + " is not admitted here: ";
  const std::string file = others.filename().string();
  EXPECT_EQ(why(), refused + "to admit this key into " + keys.string() + ", get the file " + file +
                       " from its user and run `gecos keys add " + file +
                       " USER@HOST` with the name of that user and of that user's host");
  write(others, right);
  EXPECT_EQ(why(),
            refused + others.string() +
                ": the file holds another key than its name says: copy it again, or remove it");
  write(others, "");
  EXPECT_EQ(why(), refused + others.string() + ": is empty: copy it again, or remove it");
  write(keys / (own.to_string() + ".public"), right);
  EXPECT_TRUE(directory.is_admitted(own));
  ::chmod((keys / (own.to_string() + ".public")).c_str(), 0666);
  EXPECT_FALSE(directory.is_admitted(own)) << "anybody may have written it";
}

TEST_F(KeyDirectoryTest, ProcessesThatMakeKeysAtOnceAllGetTheSame) {
  for (int round = 0; round < 10; ++round) {
    fs::remove_all(keys);
    std::array<int, 2> start{};
    std::array<int, 2> result{};
    ASSERT_EQ(::pipe(start.data()), 0);
    ASSERT_EQ(::pipe(result.data()), 0);
    constexpr int processes = 8;
    std::vector<::pid_t> children;
    for (int i = 0; i < processes; ++i) {
      const ::pid_t child = ::fork();
      ASSERT_GE(child, 0);
      if (child == 0) {
        ::close(start[1]);
        char wait = 0;
        static_cast<void>(::read(start[0], &wait, 1));  // end of file: all are there
        const auto directory = KeyDirectory::open(keys.string());
        const auto identity = directory ? directory->identity() : tl::unexpected(directory.error());
        if (!identity) ::_exit(1);
        const auto& bytes = identity->public_key().bytes;
        ::_exit(::write(result[1], bytes.data(), bytes.size()) == key_bytes ? 0 : 2);
      }
      children.push_back(child);
    }
    ::close(start[0]);
    ::close(start[1]);
    ::close(result[1]);
    for (const ::pid_t child : children) {
      int status = -1;
      ASSERT_EQ(::waitpid(child, &status, 0), child);
      EXPECT_EQ(status, 0);
    }
    std::set<PublicKey> made;
    PublicKey key;
    int answers = 0;
    while (::read(result[0], key.bytes.data(), key_bytes) == key_bytes) {
      made.insert(key);
      ++answers;
    }
    ::close(result[0]);
    EXPECT_EQ(answers, processes);
    ASSERT_EQ(made.size(), 1U);
    EXPECT_EQ(open().identity()->public_key(), *made.begin());
    for (const auto& entry : fs::directory_iterator(keys)) {
      EXPECT_FALSE(entry.path().filename().string().starts_with(".new")) << "left behind";
    }
  }
}

TEST_F(KeyDirectoryTest, ADamagedSecretIsNeverReplacedSilently) {
  ASSERT_TRUE(open().identity());
  const std::string right = content(secret());
  for (std::size_t size = 0; size < right.size(); ++size) {
    write(secret(), right.substr(0, size));
    const std::string why = why_no_identity();
    ASSERT_NE(why.find(size == 0 ? "is empty" : "is cut short"), std::string::npos) << why;
    ASSERT_EQ(content(secret()), right.substr(0, size));
  }
  for (std::size_t at = 0; at < right.size(); ++at) {
    std::string damaged = right;
    damaged[at] = damaged[at] == '0' ? '1' : '0';
    write(secret(), damaged);
    ASSERT_NE(why_no_identity(), "an identity") << at;
  }
  write(secret(), right + "\n");
  EXPECT_EQ(
      why_no_identity(),
      secret().string() +
          ": holds more than a key: restore the file, or remove it to get a new key (then every "
          "user who admitted the old key must admit the new key)");
  write(secret(), right);
  EXPECT_EQ(why_no_identity(), "an identity");
}

TEST_F(KeyDirectoryTest, APublicKeyIsNoSecretOne) {
  const PublicKey own = open().identity()->public_key();
  write(secret(), content(keys / (own.to_string() + ".public")));
  EXPECT_NE(why_no_identity().find("is not a key file of the expected kind"), std::string::npos);
}

TEST_F(KeyDirectoryTest, ASecretThatOthersCanReadIsRefusedWithTheCommandThatMendsIt) {
  ASSERT_TRUE(open().identity());
  ::chmod(secret().c_str(), 0640);
  EXPECT_EQ(
      why_no_identity(),
      secret().string() +
          ": is open to other users: run `chmod 600` on it; if another user may have read the "
          "key, remove the file instead, and a new key will be created");
}

TEST_F(KeyDirectoryTest, ADirectoryThatOthersCanEnterIsRefused) {
  open();
  ::chmod(keys.c_str(), 0755);
  EXPECT_EQ(why_not_opened(),
            keys.string() + ": the key directory is open to other users: run `chmod 700` on it");
}

TEST_F(KeyDirectoryTest, WhatIsNoDirectoryIsSaidSo) {
  fs::create_directories(keys.parent_path());
  write(keys, "");
  EXPECT_EQ(why_not_opened(),
            keys.string() + ": is not a directory; set GECOS_KEY_DIR to use another directory");
  EXPECT_FALSE(KeyDirectory::open((keys / "below").string()));
}

TEST_F(KeyDirectoryTest, ASecretIsAFileAndNoWayToAnother) {
  ASSERT_TRUE(open().identity());
  fs::rename(secret(), root / "elsewhere");
  fs::create_symlink(root / "elsewhere", secret());
  EXPECT_NE(why_no_identity().find("cannot be read"), std::string::npos);
  fs::remove(secret());
  fs::create_directory(secret());
  EXPECT_EQ(why_no_identity(), secret().string() + ": is not a regular file: remove it");
  fs::remove(secret());
  ASSERT_EQ(::mkfifo(secret().c_str(), 0600), 0);
  EXPECT_EQ(why_no_identity(), secret().string() + ": is not a regular file: remove it")
      << "and it does not wait for a writer";
}

/// Root may do everything, so what a user may not is tried as nobody, in a process of its own.
TEST_F(KeyDirectoryTest, ADirectoryThatCannotBeWrittenOrBelongsToAnotherIsSaidSo) {
  if (::geteuid() == 0) {
    const ::pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      constexpr ::uid_t nobody = 65534;
      ::chmod(root.c_str(), 0755);
      fs::create_directories(keys);
      const bool changed = ::chown(keys.c_str(), nobody, nobody) == 0 &&
                           ::chmod(keys.c_str(), 0500) == 0 && ::seteuid(nobody) == 0;
      const std::string unwritable = changed ? why_no_identity() : "";
      const bool said =
          unwritable == secret().string() +
                            ": the key cannot be written (Permission denied); set GECOS_KEY_DIR "
                            "to use another directory";
      ::_exit(said && ::seteuid(0) == 0 && ::chmod(keys.c_str(), 0700) == 0 &&
                      why_not_opened().find("belongs to uid 65534, but this program runs as uid 0; "
                                            "set GECOS_KEY_DIR") != std::string::npos
                  ? 0
                  : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    return;
  }
  open();
  ::chmod(keys.c_str(), 0500);
  EXPECT_EQ(why_no_identity(), secret().string() +
                                   ": the key cannot be written (Permission denied); set "
                                   "GECOS_KEY_DIR to use another directory");
  ::chmod(keys.c_str(), 0700);
}

TEST_F(KeyDirectoryTest, APathThatCannotBeMadeIsSaidSo) {
  keys = "/proc/gecos/keys";
  EXPECT_EQ(why_not_opened(),
            "/proc/gecos/keys: the key directory cannot be created (No such file or directory); "
            "set GECOS_KEY_DIR to use another directory");
}

class EnvironmentTest : public ::testing::Test {
 protected:
  EnvironmentTest() {
    for (const char* name : {"GECOS_KEY_DIR", "XDG_CONFIG_HOME", "HOME"}) {
      if (const char* value = std::getenv(name)) before.emplace_back(name, value);
      ::unsetenv(name);
    }
  }
  ~EnvironmentTest() override {
    for (const char* name : {"GECOS_KEY_DIR", "XDG_CONFIG_HOME", "HOME"}) ::unsetenv(name);
    for (const auto& [name, value] : before) ::setenv(name.c_str(), value.c_str(), 1);
  }
  std::vector<std::pair<std::string, std::string>> before;
};

TEST_F(EnvironmentTest, SaysWhereTheKeysAre) {
  EXPECT_TRUE(KeyDirectory::default_path().ends_with("/.config/gecos/keys"))
      << "of the user's entry";
  ::setenv("HOME", "/home/ada", 1);
  EXPECT_EQ(KeyDirectory::default_path(), "/home/ada/.config/gecos/keys");
  ::setenv("XDG_CONFIG_HOME", "/etc/ada", 1);
  EXPECT_EQ(KeyDirectory::default_path(), "/etc/ada/gecos/keys");
  ::setenv("GECOS_KEY_DIR", "", 1);
  EXPECT_EQ(KeyDirectory::default_path(), "/etc/ada/gecos/keys") << "empty is not set";
  ::setenv("GECOS_KEY_DIR", "/srv/keys", 1);
  EXPECT_EQ(KeyDirectory::default_path(), "/srv/keys");
}

class KeyOwnerTest : public KeyDirectoryTest {
 protected:
  KeyOwnerTest() {
    EXPECT_TRUE(open().identity());
    const auto all = text.bytes();
    write(keys / (key.to_string() + ".public"),
          std::string(reinterpret_cast<const char*>(all.data()), all.size()));
  }
  fs::path file() { return keys / (key.to_string() + ".owner"); }

  const PublicKey key = KeyPair::draw().public_key;
  const KeyText text = key_file_text(KeyFileKind::PublicKey, key.bytes);
};

TEST_F(KeyOwnerTest, AKeyHasTheOwnerThatItsUserWroteBesideIt) {
  EXPECT_EQ(open().owner(key).value(), std::nullopt);
  write(file(), "anna@desk\n");
  EXPECT_EQ(open().owner(key).value(), (KeyOwner{"anna", "desk"}));
  EXPECT_TRUE(open().is_admitted(key));
}

TEST_F(KeyOwnerTest, AKeyWhoseOwnerCannotBeReadIsNotAdmitted) {
  for (const std::string damaged :
       {"", "anna", "@desk", "anna@", "anna@desk@", "an na@desk", "*@desk", "\u00e4nne@desk"}) {
    write(file(), damaged);
    const auto admitted = open().admission(key);
    ASSERT_FALSE(admitted) << damaged;
    EXPECT_NE(admitted.error().text.find("does not name the owner of the key"), std::string::npos);
    EXPECT_FALSE(admitted.error().passing);
  }
  write(file(), "anna@" + std::string(KeyOwner::longest, 'd'));
  EXPECT_FALSE(open().is_admitted(key)) << "too long";
}

TEST_F(KeyOwnerTest, AnOwnerThatAnotherUserCouldHaveWrittenDoesNotCount) {
  write(file(), "anna@desk\n");
  ::chmod(file().c_str(), 0666);
  EXPECT_FALSE(open().is_admitted(key));
}

}  // namespace
}  // namespace gecos::crypto
