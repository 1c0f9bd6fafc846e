#include "gecos/base/system_error.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <system_error>

namespace gecos {
namespace {

TEST(SystemText, SaysWhatTheKernelSaid) { EXPECT_EQ(system_text(EACCES), "Permission denied"); }

TEST(SystemText, SaysWhereToLookWhenNoDescriptorsAreLeft) {
  EXPECT_EQ(system_text(EMFILE).find("Too many open files (see `ulimit -n` and"), 0u);
  EXPECT_NE(system_text(ENFILE).find("/proc/sys/fs/file-nr"), std::string::npos);
}

TEST(SystemText, AnExceptionNamesTheCallToo) {
  try {
    throw_system_error("eventfd", EMFILE);
  } catch (const std::system_error& failed) {
    const std::string what = failed.what();
    EXPECT_EQ(failed.code().value(), EMFILE);
    EXPECT_EQ(what.find("eventfd (see `ulimit -n`"), 0u) << what;
    EXPECT_NE(what.find("Too many open files"), std::string::npos) << what;
  }
}

}  // namespace
}  // namespace gecos
