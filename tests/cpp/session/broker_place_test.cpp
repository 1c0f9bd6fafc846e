// Where a Lab looks for its broker: what the program says, GECOS_BROKER, the lab file, this host.

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "../media/scratch_directory.hpp"
#include "gecos/binding.hpp"
#include "gecos/broker/broker.hpp"
#include "probe.hpp"

namespace {

using namespace std::chrono_literals;

class BrokerPlace : public ::testing::Test {
 protected:
  BrokerPlace() {
    ::unsetenv("GECOS_BROKER");
    ::setenv("GECOS_RUNTIME_DIR", directory.path().c_str(), 1);
  }
  ~BrokerPlace() override {
    for (const char* const name : {"GECOS_BROKER", "GECOS_LAB_FILE", "GECOS_RUNTIME_DIR"}) {
      ::unsetenv(name);
    }
  }
  /// Writes the file as if nobody had changed it for a minute since.
  std::string write(const std::string& text, mode_t mode = 0644) const {
    std::ofstream(file) << text;
    std::filesystem::last_write_time(file, std::filesystem::last_write_time(file) - 1min);
    EXPECT_EQ(::chmod(file.c_str(), mode), 0);
    return file;
  }
  /// Why a program with these options finds no broker.
  static std::string missing(gecos::LabOptions options) {
    gecos::Lab lab(std::move(options));
    const auto created = lab.create<probe::Probe>("PROBE", {.patience = 5s});
    return created ? "a proxy" : created.error().to_string();
  }

  const gecos::media::ScratchDirectory directory;
  const std::string file = directory.path() + "/lab.toml";
  const std::string no_broker =
      "PROBE: NO_SERVER: no broker answers; start `gecos up` (a laboratory on this machine) or "
      "`gecos broker`, or give the broker's address in GECOS_BROKER or below [broker] in the lab "
      "file "
      "(tried ";
  const std::string unusable =
      "PROBE: NO_SERVER: the lab file, which may name the broker, cannot be used: " + file;
  const std::string remedy = "; correct that, or name the broker in GECOS_BROKER";
};

constexpr const char* of_file = "[broker]\naddress = \"inproc:of_file\"\n";

TEST_F(BrokerPlace, IsTheOneOfTheLabFileThatTheProgramOrTheEnvironmentNames) {
  const std::string tried =
      no_broker + "inproc:of_file: no server in this process has this address; [broker] in " +
      file + ":2 names this address)";
  EXPECT_EQ(missing({.lab_file = write(of_file)}), tried);
  ::setenv("GECOS_LAB_FILE", file.c_str(), 1);
  EXPECT_EQ(missing({}), tried);
}

TEST_F(BrokerPlace, InGecosBrokerComesBeforeThatOfTheLabFile) {
  ::setenv("GECOS_BROKER", "inproc:of_environment", 1);
  EXPECT_EQ(missing({.lab_file = write(of_file)}),
            no_broker + "inproc:of_environment: no server in this process has this address)");
}

TEST_F(BrokerPlace, OfTheProgramComesBeforeAllOthers) {
  ::setenv("GECOS_BROKER", "inproc:of_environment", 1);
  EXPECT_EQ(missing({.broker = "inproc:of_program", .lab_file = write(of_file)}),
            no_broker + "inproc:of_program: no server in this process has this address)");
}

TEST_F(BrokerPlace, IsThisHostIfTheLabFileNamesNone) {
  for (const char* const text : {"[broker]\nstart = true\n", "[broker]\nstart = false\n", "\n"}) {
    EXPECT_EQ(missing({.lab_file = write(text)})
                  .find(no_broker + "shm:" + directory.path() + "/BROKER.sock"),
              0u)
        << text;
  }
}

TEST_F(BrokerPlace, IsThisHostIfNoSettingNamesALabFileAndThereIsNone) {
  if (std::filesystem::exists("/etc/gecos/lab.toml")) GTEST_SKIP() << "this host has a lab file";
  EXPECT_EQ(missing({}).find(no_broker + "shm:" + directory.path() + "/BROKER.sock"), 0u);
}

TEST_F(BrokerPlace, IsNotSoughtElsewhereIfTheLabFileCannotBeTrusted) {
  EXPECT_EQ(missing({.lab_file = write(of_file, 0666)}),
            unusable +
                ": other users may write to the file and could admit anyone and name any broker; "
                "run: chmod go-w " +
                file + remedy);
}

TEST_F(BrokerPlace, IsNotSoughtElsewhereIfTheLabFileIsMissingOrHasAnError) {
  EXPECT_EQ(missing({.lab_file = file}),
            unusable + ": the file cannot be read: No such file or directory" + remedy);
  EXPECT_EQ(missing({.lab_file = write("[broker]\nadress = \"lcm\"\n")}),
            unusable + ":2: broker.adress: this key is unknown; did you mean address?" + remedy);
  EXPECT_EQ(missing({.lab_file = write("[broker]\naddress = \"lcm\"\nstart = true\n")}),
            unusable +
                ":2: broker.address: this address names a broker that runs already, but "
                "`start = true` starts one; leave out `address` or `start`" +
                remedy);
}

TEST_F(BrokerPlace, OfAProgramThatContainsABrokerIsThatBroker) {
  gecos::Lab lab({.lab_file = write("[broker]\naddress = \"inproc:of_file\"\n")});
  gecos::broker::Broker broker;
  gecos::Server server(lab);
  const auto served = broker.serve(server, {gecos::media::Kind::Inproc});
  ASSERT_TRUE(served) << served.error().text;
  const auto found = gecos::session::broker_session(gecos::session::LabAccess::context(lab),
                                                    gecos::deadline_after(5s));
  EXPECT_TRUE(found) << found.error();
}

TEST_F(BrokerPlace, IsReadAnewForEachSearch) {
  gecos::Lab lab({.lab_file = write(of_file)});
  const auto why = [&] {
    const auto created = lab.create<probe::Probe>("PROBE", {.patience = 5s});
    return created ? "a proxy" : created.error().to_string();
  };
  EXPECT_NE(why().find("inproc:of_file"), std::string::npos);
  write("[broker]\naddress = \"inproc:edited\"\n");
  EXPECT_NE(why().find("inproc:edited"), std::string::npos);
}

}  // namespace
