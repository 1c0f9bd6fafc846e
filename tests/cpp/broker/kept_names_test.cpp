#include "gecos/broker/kept_names.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "child.hpp"
#include "gecos/base/pid_namespace.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/kinds.hpp"

namespace gecos::broker {
namespace {

Entry of_process(const std::string& name, std::int32_t pid) {
  Entry entry;
  entry.name = name;
  entry.pid = pid;
  entry.pid_namespace = pid_namespace();
  entry.host = media::host_identity();
  entry.boot = 7;
  return entry;
}

/// A broker that writes, and the one after it.
class Kept : public ::testing::Test {
 protected:
  Kept() {
    char made[] = "/tmp/gecos-kept-XXXXXX";
    folder_ = ::mkdtemp(made);
    path_ = folder_ + "/BROKER.names";
  }
  ~Kept() override { std::filesystem::remove_all(folder_); }

  void keep(const std::vector<Entry>& entries) {
    Processes processes;
    for (const Entry& entry : entries) processes.watch(entry.pid);
    KeptNames(path_).keep(entries, processes);
  }
  std::vector<Entry> living() {
    next_.emplace();
    return KeptNames(path_).living(*next_);
  }

  std::string folder_;
  std::string path_;
  std::optional<Processes> next_;
};

TEST_F(Kept, ObjectsOfLivingProcessesAreKnownToTheNextBroker) {
  Child child;
  const std::vector<Entry> entries{of_process("LAMP", child.pid()),
                                   of_process("RX90", child.pid())};
  EXPECT_TRUE(living().empty()) << "there was no broker before";
  keep(entries);
  EXPECT_EQ(living(), entries);
  EXPECT_EQ(next_->watched(), std::vector<std::int32_t>{child.pid()});
}

TEST_F(Kept, ObjectsOfProcessesThatHaveEndedAreNot) {
  std::optional<Child> child(std::in_place);
  keep({of_process("RX90", child->pid())});
  child.reset();
  EXPECT_TRUE(living().empty());
}

TEST_F(Kept, ObjectsOfALaterProcessWithTheSameNumberAreNot) {
  Child child;
  const Processes knows_no_start;
  KeptNames(path_).keep({of_process("RX90", child.pid())}, knows_no_start);
  EXPECT_TRUE(living().empty());
}

TEST_F(Kept, ObjectsOfThisProcessAreNotBecauseItRuns) {
  keep({of_process("RX90", ::getpid())});
  EXPECT_TRUE(living().empty());
}

TEST_F(Kept, ObjectsOfAnotherHostAreNot) {
  Child child;
  Entry entry = of_process("RX90", child.pid());
  entry.host = "0" + entry.host;
  keep({entry});
  EXPECT_TRUE(living().empty());
}

TEST_F(Kept, AFileThatIsNotOneOfABrokerIsLeftOut) {
  std::ofstream(path_) << "RX90\n";
  EXPECT_TRUE(living().empty());
  Child child;
  keep({of_process("RX90", child.pid())});
  EXPECT_EQ(living().size(), 1u) << "and is replaced";
}

TEST_F(Kept, NamesOfTheBrokerBeforeAreForgottenWhenNoObjectIsLeft) {
  Child child;
  keep({of_process("RX90", child.pid())});
  EXPECT_EQ(living().size(), 1u);
  KeptNames(path_).keep({}, Processes());
  EXPECT_TRUE(living().empty());
}

TEST_F(Kept, AFileThatCannotBeWrittenIsReportedOnceAndTriedAgain) {
  Child child;
  Processes processes;
  processes.watch(child.pid());
  std::filesystem::create_directory(path_ + ".new");
  KeptNames names(path_);
  ::testing::internal::CaptureStderr();
  names.keep({of_process("RX90", child.pid())}, processes);
  names.keep({of_process("RX90", child.pid())}, processes);
  const std::string logged = ::testing::internal::GetCapturedStderr();
  const std::size_t first = logged.find("cannot write " + path_);
  EXPECT_NE(first, std::string::npos) << logged;
  EXPECT_EQ(logged.find("cannot write", first + 1), std::string::npos) << logged;
  std::filesystem::remove(path_ + ".new");
  names.keep({of_process("RX90", child.pid())}, processes);
  EXPECT_EQ(living().size(), 1u);
}

TEST(SeesProcess, OnlyOfThisMachineInThisPidNamespace) {
  const Entry here = of_process("RX90", ::getpid());
  EXPECT_TRUE(session::sees_process(here));
  Entry other = here;
  other.pid_namespace += 1;
  EXPECT_FALSE(session::sees_process(other)) << "in a container with this runtime directory";
  other.pid_namespace = 0;
  EXPECT_FALSE(session::sees_process(other)) << "its server does not say";
  other = here;
  other.host += "0";
  EXPECT_FALSE(session::sees_process(other));
  other = here;
  other.pid = 0;
  EXPECT_FALSE(session::sees_process(other));
}

}  // namespace
}  // namespace gecos::broker
