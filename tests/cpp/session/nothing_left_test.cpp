// Programs that have too few descriptors or threads: they say so, and "ready" means reachable.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <memory>
#include <vector>

#include "child.hpp"
#include "place.hpp"
#include "probe.hpp"

namespace {

using probe::Child;
using probe::Place;

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
  const auto most = static_cast<rlim_t>(lowest_free + spare);
  const rlimit few{most, most};
  ::setrlimit(RLIMIT_NOFILE, &few);
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
    // Root may have as many as it likes.
    if (::geteuid() == 0 && ::setuid(20'003) != 0) return;
    const rlimit one{1, 1};
    ::setrlimit(RLIMIT_NPROC, &one);
    serve_a_broker(line);
  });
  server.line().say("go");
  const std::string said = server.line().hear();
  EXPECT_NE(said.find("this process has no resources left for a Lab: the thread gecos-maint (see "
                      "`ulimit -u`): Resource temporarily unavailable"),
            std::string::npos)
      << said;
  server.line().say("end");
  EXPECT_EQ(server.wait(), 0);
}

TEST(NothingLeft, AClientWithoutThreadsSaysSo) {
  Child client([](Child::Line& line) {
    line.hear();
    if (::geteuid() == 0 && ::setuid(20'003) != 0) return;
    const rlimit one{1, 1};
    ::setrlimit(RLIMIT_NPROC, &one);
    gecos::Lab lab;
    line.say(lab.create<probe::Probe>("PROBE").error().to_string());
    lab.close();
  });
  client.line().say("go");
  EXPECT_EQ(
      client.line().hear(),
      "PROBE: NO_SERVER: this process has no resources left for a Lab: the thread gecos-maint (see "
      "`ulimit -u`): Resource temporarily unavailable");
  EXPECT_EQ(client.wait(), 0);
}

}  // namespace
