// Programs that have too few descriptors or threads: they say so, and "ready" means reachable.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <memory>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "child.hpp"
#include "place.hpp"
#include "probe.hpp"

#if defined(__SANITIZE_ADDRESS__)
/// Replaces the function of the C library, and succeeds beyond the soft limit of descriptors too.
/// UndefinedBehaviorSanitizer needs a pipe to find out whether a vtable can be read; without a
/// descriptor it reports every object of a type that it has not met before.
extern "C" [[gnu::visibility("default")]] int pipe(int* ends) noexcept {
  static std::mutex& raising = *new std::mutex;
  const std::lock_guard lock(raising);
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  const rlimit raised{limit.rlim_max, limit.rlim_max};
  ::setrlimit(RLIMIT_NOFILE, &raised);
  const int result = ::pipe2(ends, 0);
  ::setrlimit(RLIMIT_NOFILE, &limit);
  return result;
}
#endif

namespace {

using probe::Child;
using probe::Place;

/// While it lives, this process may have at most `most` of a resource. Only the soft limit changes,
/// because LeakSanitizer needs a thread and descriptors at the end of the process.
class Limit {
 public:
  using Resource = decltype(RLIMIT_NOFILE);

  Limit(Resource resource, rlim_t most) : resource_(resource) {
    ::getrlimit(resource_, &before_);
    const rlimit lowered{most, before_.rlim_max};
    if (::setrlimit(resource_, &lowered) != 0) throw std::runtime_error("setrlimit failed");
  }
  ~Limit() { ::setrlimit(resource_, &before_); }
  Limit(const Limit&) = delete;
  Limit& operator=(const Limit&) = delete;

 private:
  const Resource resource_;
  rlimit before_{};
};

/// Root may have as many threads as it likes, so this process becomes another user. The kernel then
/// forbids LeakSanitizer to trace the threads of the process, until the process allows it.
void become_a_user() {
  if (::geteuid() != 0) return;
  if (::setuid(20'003) != 0) throw std::runtime_error("setuid failed");
  if (::prctl(PR_SET_DUMPABLE, 1) != 0) throw std::runtime_error("prctl failed");
}

/// Serves a broker until it hears a word, or says why it cannot.
void serve_a_broker(Child::Line& line) {
  gecos::Lab lab;
  gecos::broker::Broker broker;
  gecos::Server server(lab);
  const auto served = broker.serve(server, {});
  line.say(served ? "ready" : served.error().text);
  line.hear();
}

/// A process that may open `spare` descriptors more than it has.
void serve_with_descriptors(Child::Line& line, int spare) {
  line.hear();
  const int lowest_free = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  ::close(lowest_free);
  const Limit few(RLIMIT_NOFILE, static_cast<rlim_t>(lowest_free + spare));
  serve_a_broker(line);
}

TEST(NothingLeft, AServerIsReadyOnlyWhereAClientReachesIt) {
  const Place place;
  std::vector<std::unique_ptr<Child>> servers;
  for (int spare = 0; spare < 48; ++spare) {
    servers.push_back(std::make_unique<Child>(
        [spare](Child::Line& line) { serve_with_descriptors(line, spare); }));
  }
  std::size_t ready = 0;
  for (const auto& server : servers) {
    server->line().say("go");
    const std::string said = server->line().hear();
    if (said == "ready") {
      ++ready;
      gecos::Lab lab;
      const auto created =
          lab.create<probe::Probe>("NOBODY", {.patience = std::chrono::seconds(20)});
      EXPECT_NE(created.error().to_string().find("no object is called NOBODY"), std::string::npos)
          << created.error();
    } else {
      EXPECT_NE(said.find("Too many open files"), std::string::npos) << said;
      EXPECT_NE(said.find("ulimit -n"), std::string::npos) << said;
    }
    server->line().say("end");
    EXPECT_EQ(server->wait(), 0);
  }
  EXPECT_GT(ready, 0u);
  EXPECT_LT(ready, servers.size() / 2) << "most had too few";
}

TEST(NothingLeft, AServerWithoutThreadsSaysSo) {
  const Place place;
  Child server([](Child::Line& line) {
    line.hear();
    become_a_user();
    const Limit one(RLIMIT_NPROC, 1);
    serve_a_broker(line);
  });
  server.line().say("go");
  const std::string said = server.line().hear();
  EXPECT_NE(said.find("this process has no resources left for a broker: cannot start the thread "
                      "gecos-revoked "
                      "(see `ulimit -u`): Resource temporarily unavailable"),
            std::string::npos)
      << said;
  server.line().say("end");
  EXPECT_EQ(server.wait(), 0);
}

TEST(NothingLeft, AClientWithoutThreadsSaysSo) {
  Child client([](Child::Line& line) {
    line.hear();
    become_a_user();
    const Limit one(RLIMIT_NPROC, 1);
    gecos::Lab lab;
    line.say(lab.create<probe::Probe>("PROBE").error().to_string());
    lab.close();
  });
  client.line().say("go");
  EXPECT_EQ(client.line().hear(),
            "PROBE: NO_SERVER: this process has no resources left for a Lab: cannot start the "
            "thread gecos-maint (see "
            "`ulimit -u`): Resource temporarily unavailable");
  EXPECT_EQ(client.wait(), 0);
}

}  // namespace
