#include "gecos/base/per_process.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "gecos/base/mutex.hpp"

namespace gecos {
namespace {

struct Noted {
  Mutex mutex;
  int number = 0;
};

constinit PerProcess<Noted> noted;

TEST(PerProcess, IsOneObjectForAProcess) {
  noted.get().number = 7;
  EXPECT_EQ(noted.get().number, 7);
  EXPECT_EQ(&noted.get(), &noted.get());
}

TEST(PerProcess, AForkedChildBeginsAnewAlsoIfItsParentHeldTheMutex) {
  Noted& of_parent = noted.get();
  const MutexLock lock(of_parent.mutex);
  of_parent.number = 7;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    Noted& own = noted.get();
    ::_exit(own.mutex.try_lock() && own.number == 0 && &own == &noted.get() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(&noted.get(), &of_parent);
}

}  // namespace
}  // namespace gecos
