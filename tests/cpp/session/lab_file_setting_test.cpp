// A server whose lab file cannot count says so when it adds an object.

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <fstream>

#include "../media/scratch_directory.hpp"
#include "probe.hpp"

namespace {

class LabFileSetting : public ::testing::Test {
 protected:
  /// Why a server with this lab file serves nothing; an empty text when it does.
  std::string refusal(const std::string& file) {
    gecos::Lab lab({.lab_file = file});
    probe::ProbeServant servant;
    gecos::Server server(lab);
    const auto added =
        server.add("LOCAL", servant, {.media = {gecos::media::Kind::Inproc}, .well_known = true});
    return added ? "" : added.error().text;
  }
  std::string write(const std::string& text, mode_t mode = 0644) {
    std::ofstream(path) << text;
    EXPECT_EQ(::chmod(path.c_str(), mode), 0);
    return path;
  }

  const gecos::media::ScratchDirectory directory;
  const std::string path = directory.path() + "/lab.toml";
};

TEST_F(LabFileSetting, ThatIsNotAFileOfThisUserAloneIsRefused) {
  EXPECT_EQ(refusal(path), "LOCAL is not served: " + path +
                               ": the file cannot be read: No such file or directory");
  EXPECT_EQ(refusal(write("[allow]\nusers = []\n")), "");
  EXPECT_EQ(refusal(write("", 0666)),
            "LOCAL is not served: " + path +
                ": other users may write to the file and could admit anyone and name any broker; "
                "run: chmod go-w " +
                path);
  EXPECT_EQ(refusal(directory.path()),
            "LOCAL is not served: " + directory.path() + ": this is not a regular file");
}

TEST_F(LabFileSetting, WithAnErrorIsRefusedWithItsLine) {
  EXPECT_EQ(
      refusal(write("[allow]\nuser = []\n")),
      "LOCAL is not served: " + path + ":2: allow.user: this key is unknown; did you mean users?");
}

TEST_F(LabFileSetting, WithAnErrorIsRefusedForEachObject) {
  gecos::Lab lab({.lab_file = write("[objects.SECOND]\nzones = \"CELL\"\n")});
  gecos::Server server(lab);
  probe::ProbeServant servant;
  for (const char* const name : {"FIRST", "SECOND"}) {
    const auto added =
        server.add(name, servant, {.media = {gecos::media::Kind::Inproc}, .well_known = true});
    ASSERT_FALSE(added) << name << " would be served in no zone";
    EXPECT_NE(added.error().text.find("did you mean zone?"), std::string::npos) << added.error();
  }
}

TEST_F(LabFileSetting, OfTheProgramComesBeforeThatOfTheEnvironment) {
  ::setenv("GECOS_LAB_FILE", "/nonexistent/lab.toml", 1);
  EXPECT_EQ(refusal(write("")), "");
  EXPECT_NE(refusal("").find("/nonexistent/lab.toml: the file cannot be read"), std::string::npos);
  ::unsetenv("GECOS_LAB_FILE");
}

}  // namespace
