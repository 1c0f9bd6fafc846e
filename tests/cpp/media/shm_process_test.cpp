// shm between two processes: calls, and every way in which the other one can go.

#include <gtest/gtest.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "child_process.hpp"
#include "gecos/media/buffers/bulk.hpp"
#include "gecos/media/shm/acceptor.hpp"
#include "gecos/media/shm/shm.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

using namespace std::chrono_literals;

class ShmProcess : public testing::Test {
 protected:
  std::string well_known() const { return "shm:" + directory_.path() + "/RX90.sock"; }

  std::unique_ptr<Acceptor> listen() const {
    return make_shm({.directory = directory_.path()})->listen("RX90", true).value();
  }
  End connect() const {
    auto connection = make_shm({.directory = directory_.path()})->connect(well_known());
    if (!connection) ADD_FAILURE() << connection.error().text;
    return End(connection ? std::move(*connection) : nullptr);
  }

  const ScratchDirectory directory_;
};

/// A server that echoes until it has read "end".
void echo(Acceptor& acceptor, const std::function<void()>& say_ready) {
  say_ready();
  End end(wait_for_client(acceptor));
  for (std::string text; text != "end";) {
    text = end.receive();
    if (!end.send(text)) break;
  }
}

TEST_F(ShmProcess, TwoProcessesAnswerEachOther) {
  ChildProcess server([&](const auto& say_ready) { echo(*listen(), say_ready); });
  ASSERT_TRUE(server.wait_ready());
  End client = connect();
  EXPECT_EQ(client.connection->peer().pid, server.pid());
  EXPECT_EQ(client.connection->peer().uid, ::geteuid());
  const std::string large(client.connection->capabilities().largest_packet, 'x');
  for (int i = 0; i < 2000; ++i) {
    const std::string text = i % 500 == 0 ? large : std::to_string(i);
    ASSERT_TRUE(client.send(text));
    ASSERT_TRUE(client.receive() == text) << text.size();
  }
  ASSERT_TRUE(client.send("end"));
  EXPECT_EQ(client.receive(), "end");
  EXPECT_EQ(client.wait_for_loss(), Loss::Closed) << client.connection->loss_text();
  EXPECT_EQ(server.wait(), 0);
}

TEST_F(ShmProcess, AKilledServerIsSeenByASleeperAtOnce) {
  ChildProcess server([&](const auto& say_ready) {
    const auto acceptor = listen();
    say_ready();
    const End end(wait_for_client(*acceptor));
    ::pause();
  });
  ASSERT_TRUE(server.wait_ready());
  End client = connect();
  ASSERT_TRUE(client.connection->prepare_to_sleep());
  std::thread killing([&] { server.kill(); });
  // The promise: the kernel reports it; 100 ms is five times what a loaded host takes for that.
  const TimePoint deadline = std::chrono::steady_clock::now() + 100ms;
  killing.join();
  while (client.connection->loss() == Loss::None) {
    ASSERT_NE(sleep_on(client.connection->descriptors(), deadline), Wake::TimedOut);
    client.connection->woke();
  }
  EXPECT_EQ(client.connection->loss(), Loss::Died);
  EXPECT_NE(client.connection->loss_text().find(std::to_string(*client.connection->peer().pid)),
            std::string::npos);
  EXPECT_EQ(client.send("anybody?").error(), SendProblem::Lost);
}

TEST_F(ShmProcess, WhatADeadServerTookAndAnsweredStaysKnown) {
  ChildProcess server([&](const auto& say_ready) {
    const auto acceptor = listen();
    say_ready();
    End end(wait_for_client(*acceptor));
    for (int i = 0; i < 3; ++i) end.receive();
    [[maybe_unused]] const auto sent = end.send("answer");
    ::raise(SIGKILL);
  });
  ASSERT_TRUE(server.wait_ready());
  End client = connect();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(client.send("command"));
  EXPECT_EQ(client.wait_for_loss(), Loss::Died);
  EXPECT_EQ(client.connection->taken_by_peer(), 3u);
  EXPECT_EQ(client.receive(), "answer");
  EXPECT_EQ(client.connection->taken_by_peer(), 3u);
}

/// How many areas this process sees, in its memory and among its descriptors.
std::size_t areas_seen() {
  std::size_t seen = 0;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    if (line.find("memfd:gecos bulk") != std::string::npos) ++seen;
  }
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    const auto target = std::filesystem::read_symlink(entry.path(), gone).string();
    if (target.find("memfd:gecos bulk") != std::string::npos) ++seen;
  }
  return seen;
}

TEST_F(ShmProcess, OfLargePacketsToOneThatDiesItIsKnownWhichItTook) {
  const std::string image(2'000'000, 'x');
  ChildProcess server([&](const auto& say_ready) {
    const auto acceptor = listen();
    say_ready();
    End end(wait_for_client(*acceptor));
    for (int i = 0; i < 3; ++i) end.receive();
    [[maybe_unused]] const auto sent = end.send(image + "answer");
    ::raise(SIGKILL);
  });
  ASSERT_TRUE(server.wait_ready());
  {
    End client = connect();
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(client.send(i % 2 == 0 ? image : "command"));
    EXPECT_EQ(client.wait_for_loss(), Loss::Died);
    EXPECT_EQ(client.connection->taken_by_peer(), 3u);
    EXPECT_TRUE(client.receive() == image + "answer") << "what it had sent is there";
    EXPECT_EQ(areas_seen(), 2u);
  }
  EXPECT_EQ(areas_seen(), 0u);
}

TEST_F(ShmProcess, AnAreaIsGivenBackToTheKernelWhenItIsNotUsed) {
  const std::string image(2'000'000, 'x');
  ChildProcess server([&](const auto& say_ready) { echo(*listen(), say_ready); });
  ASSERT_TRUE(server.wait_ready());
  End client = connect();
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(client.send(image));
    ASSERT_TRUE(client.receive() == image);
    EXPECT_EQ(areas_seen(), 2u);
    for (unsigned i = 0; i <= area_kept; ++i) client.connection->beat();
    EXPECT_EQ(areas_seen(), 1u) << "ours is gone; the server's maintenance does not beat here";
  }
  ASSERT_TRUE(client.send("end"));
  EXPECT_EQ(client.receive(), "end");
}

TEST_F(ShmProcess, AForkedChildHoldsNoArea) {
  const auto acceptor = listen();
  End client = connect();
  End server(wait_for_client(*acceptor));
  const std::string image(2'000'000, 'x');
  ASSERT_TRUE(client.send(image));
  ASSERT_TRUE(server.receive() == image);
  ASSERT_EQ(areas_seen(), 2u);
  ChildProcess child([&](const auto&) { ::_exit(areas_seen() == 0 ? 0 : 1); });
  EXPECT_EQ(child.wait(), 0);
  ASSERT_TRUE(client.send(image));
  ASSERT_TRUE(server.receive() == image);
}

constexpr std::size_t little = std::size_t{8} << 20;  // bytes; an area takes 64 MiB

TEST_F(ShmProcess, AStreamForWhichThereIsNoAddressSpaceEndsNoConnection) {
  const auto acceptor = listen();
  End client = connect();
  End server(wait_for_client(*acceptor));
  ASSERT_TRUE(server.send("welcome"));
  ASSERT_EQ(client.receive(), "welcome");
  struct Way {
    End& from;
    End& to;
  };
  for (const Way& way : {Way{server, client}, Way{client, server}}) {
    const auto large = way.from.connection->make_stream(1'000'000, 16);
    const auto small = way.from.connection->make_stream(100, 4);
    ASSERT_TRUE(way.from.connection->share(7, *large));
    ASSERT_TRUE(way.from.connection->share(8, *small));
    {
      const LittleAddressSpace tight(little);
      EXPECT_NE(way.to.wait_for_stream(8), nullptr);
      EXPECT_EQ(way.to.connection->open_stream(7), nullptr);
    }
    const std::string why = way.to.connection->why_no_stream(7);
    EXPECT_NE(why.find("this process cannot map "), std::string::npos) << why;
    EXPECT_EQ(way.to.connection->loss(), Loss::None) << way.to.connection->loss_text();
    ASSERT_TRUE(way.from.send("still there"));
    EXPECT_EQ(way.to.receive(), "still there");
    ASSERT_TRUE(way.from.connection->share(7, *large)) << "later there may be room";
    EXPECT_NE(way.to.wait_for_stream(7), nullptr);
  }
}

TEST_F(ShmProcess, LargePacketsArriveAlsoWithoutTheAddressSpaceForAnArea) {
  const auto acceptor = listen();
  End client = connect();
  End server(wait_for_client(*acceptor));
  ASSERT_TRUE(server.send("welcome"));
  ASSERT_EQ(client.receive(), "welcome");
  const std::string first(100'000, 'x');
  const std::string second(300'000, 'y');
  ASSERT_TRUE(server.send(first));
  ASSERT_TRUE(server.send(second));
  {
    const LittleAddressSpace tight(little);
    EXPECT_TRUE(client.receive() == first) << client.connection->loss_text();
    EXPECT_TRUE(client.receive() == second) << client.connection->loss_text();
  }
  EXPECT_EQ(client.connection->loss(), Loss::None) << client.connection->loss_text();
  EXPECT_EQ(areas_seen(), 2u) << "the mapping of the writer and the descriptor of the reader";
  ChildProcess child([&](const auto&) { ::_exit(areas_seen() == 0 ? 0 : 1); });
  EXPECT_EQ(child.wait(), 0) << "a forked child holds no area";
  for (unsigned i = 0; i <= area_kept; ++i) server.connection->beat();
  EXPECT_EQ(client.connection->loss(), Loss::None);
  EXPECT_EQ(areas_seen(), 0u);
}

TEST_F(ShmProcess, AServerThatDiedBeforeItAcceptedHasTakenNothing) {
  ChildProcess server([&](const auto& say_ready) {
    const auto acceptor = listen();
    say_ready();
    ::pause();
  });
  ASSERT_TRUE(server.wait_ready());
  End client = connect();
  ASSERT_TRUE(client.send("command"));
  server.kill();
  EXPECT_EQ(client.wait_for_loss(), Loss::Died);
  EXPECT_EQ(client.connection->taken_by_peer(), 0u);
}

TEST_F(ShmProcess, AKilledClientIsSeenByTheServer) {
  const auto acceptor = listen();
  ChildProcess client([&](const auto& say_ready) {
    End end = connect();
    [[maybe_unused]] const auto sent = end.send("hello");
    say_ready();
    ::pause();
  });
  ASSERT_TRUE(client.wait_ready());
  End server(wait_for_client(*acceptor));
  EXPECT_EQ(server.receive(), "hello");
  EXPECT_EQ(server.connection->loss(), Loss::None);
  client.kill();
  EXPECT_EQ(server.wait_for_loss(), Loss::Died);
}

TEST_F(ShmProcess, AProcessThatExitsWithoutAWordHasDied) {
  const auto acceptor = listen();
  ChildProcess client([&](const auto& say_ready) {
    End end = connect();
    say_ready();
    end.receive();
    ::_exit(0);
  });
  ASSERT_TRUE(client.wait_ready());
  End server(wait_for_client(*acceptor));
  ASSERT_NE(server.connection, nullptr);
  ASSERT_TRUE(server.send("go"));
  EXPECT_EQ(server.wait_for_loss(), Loss::Died);
}

TEST_F(ShmProcess, AChildOfTheDeadServerThatHoldsItsSocketHidesNothing) {
  ChildProcess server([&](const auto& say_ready) {
    const auto acceptor = listen();
    say_ready();
    End end(wait_for_client(*acceptor));
    end.receive();
    // Past the handlers of fork(), as a container's tool or another language's runtime may do it.
    if (::syscall(SYS_clone, SIGCHLD, nullptr, nullptr, nullptr, nullptr) == 0) {
      ::prctl(PR_SET_PDEATHSIG, 0);
      ::alarm(5);
      ::pause();
    }
    [[maybe_unused]] const auto sent = end.send("forked");
    ::pause();
  });
  ASSERT_TRUE(server.wait_ready());
  End client = connect();
  ASSERT_TRUE(client.send("go"));
  ASSERT_EQ(client.receive(), "forked");
  ::kill(server.pid(), SIGKILL);  // not reaped yet: its death alone must do
  EXPECT_EQ(client.wait_for_loss(), Loss::Died) << client.connection->loss_text();
}

TEST_F(ShmProcess, AStoppedPeerIsNotLost) {
  ChildProcess server([&](const auto& say_ready) { echo(*listen(), say_ready); });
  ASSERT_TRUE(server.wait_ready());
  End client = connect();
  ASSERT_TRUE(client.send("one"));
  ASSERT_EQ(client.receive(), "one");
  server.kill(SIGSTOP);
  const std::uint64_t beats = client.connection->beats_seen();
  ASSERT_TRUE(client.send("two"));
  EXPECT_EQ(client.connection->loss(), Loss::None)
      << "only its silence tells, and the session judges that";
  EXPECT_EQ(client.connection->beats_seen(), beats);
  server.kill(SIGCONT);
  EXPECT_EQ(client.receive(), "two");
  ASSERT_TRUE(client.send("end"));
  EXPECT_EQ(client.receive(), "end");
}

TEST_F(ShmProcess, AStreamOfADeadServerCanStillBeReadAndHoldsNobody) {
  ChildProcess server([&](const auto& say_ready) {
    const auto acceptor = listen();
    say_ready();
    End end(wait_for_client(*acceptor));
    const auto writer = acceptor->make_stream(64, 4);
    [[maybe_unused]] const auto shared = end.connection->share(1, *writer);
    for (;;) [[maybe_unused]] const auto published = writer->publish(bytes_of("pose"), 1);
  });
  ASSERT_TRUE(server.wait_ready());
  End client = connect();
  const auto reader = client.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  StreamSample sample;
  ASSERT_TRUE(client.wait([&] { return reader->latest(1000, sample); }));
  server.kill();
  EXPECT_EQ(client.wait_for_loss(), Loss::Died);
  reader->latest(0, sample);
  EXPECT_EQ(text_of(sample.bytes), "pose");
  EXPECT_FALSE(reader->latest(~std::uint64_t{0}, sample));
}

TEST_F(ShmProcess, AKilledServersSocketGivesWayToTheNext) {
  for (int life = 0; life < 3; ++life) {
    ChildProcess server([&](const auto& say_ready) {
      const auto medium = make_shm({.directory = directory_.path()});
      const auto acceptor = medium->listen("RX90", true).value();
      const auto other = medium->listen("LASER", false).value();
      say_ready();
      ::pause();
    });
    ASSERT_TRUE(server.wait_ready());
    EXPECT_TRUE(connect().connection);
    server.kill();
  }
  listen();
  std::size_t left = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory_.path())) {
    ADD_FAILURE() << "left behind: " << entry.path();
    ++left;
  }
  EXPECT_EQ(left, 0u);
}

TEST_F(ShmProcess, NothingIsNamedInDevShm) {
  const auto count = [] {
    const std::filesystem::directory_iterator all("/dev/shm");
    return std::distance(begin(all), end(all));
  };
  const auto before = count();
  const auto acceptor = listen();
  End client = connect();
  const auto server = wait_for_client(*acceptor);
  const auto writer = acceptor->make_stream(64, 4);
  EXPECT_EQ(count(), before);
}

TEST_F(ShmProcess, WhoStandsBehindManyThatAreSilentIsLetInThoughEventsAreEdges) {
  const auto acceptor = listen();
  const int watched = ::epoll_create1(EPOLL_CLOEXEC);
  epoll_event event{.events = EPOLLIN | EPOLLET, .data = {}};
  ASSERT_EQ(::epoll_ctl(watched, EPOLL_CTL_ADD, acceptor->descriptors()[0], &event), 0);
  const std::string address = acceptor->address();
  std::vector<Descriptor> silent;
  for (int i = 0; i < 200; ++i)
    silent.push_back(shm::connect_to(address.substr(address.find(':') + 1)));
  End client = connect();
  std::unique_ptr<Connection> server;
  while (!server && ::epoll_wait(watched, &event, 1, 0) == 1) server = acceptor->accept();
  EXPECT_NE(server, nullptr);
  ::close(watched);
}

TEST_F(ShmProcess, AClientIsTurnedAwayWhenNoDescriptorIsLeft) {
  const auto acceptor = listen();
  End first = connect();
  auto first_server = wait_for_client(*acceptor);
  ASSERT_NE(first_server, nullptr);
  ChildProcess clients([&](const auto& say_ready) {
    std::vector<End> ends;
    for (int i = 0; i < 20; ++i) ends.push_back(connect());
    say_ready();
    // Whoever could not be let in is told so; the others stay.
    for (End& end : ends) {
      end.wait(
          [&] { return end.connection->loss() != Loss::None || end.connection->beats_seen() > 0; });
    }
    ::_exit(0);
  });
  ASSERT_TRUE(clients.wait_ready());
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  const rlimit tight{open_descriptors() + 12, before.rlim_max};
  ::setrlimit(RLIMIT_NOFILE, &tight);
  std::vector<std::unique_ptr<Connection>> connections;
  while (auto connection = acceptor->accept()) {
    connection->beat();
    connections.push_back(std::move(connection));
  }
  EXPECT_EQ(sleep_on(acceptor->descriptors(), TimePoint{}), Wake::TimedOut)
      << "who watches for edges comes once";
  ::setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(clients.wait(), 0);
  ASSERT_TRUE(first.send("still served"));
  EXPECT_EQ(End(std::move(first_server)).receive(), "still served");
}

TEST_F(ShmProcess, AClientHearsThatTheDescriptorsOfTheServerEndedWhileItWasLetIn) {
  const auto acceptor = listen();
  // For its socket, for what tells its death, its memory and its eventfd, our memory, our eventfd.
  for (const rlim_t left : {0, 1, 2, 3, 4}) {
    End client = connect();
    rlimit before{};
    ::getrlimit(RLIMIT_NOFILE, &before);
    const rlimit tight{open_descriptors() - 1 + left, before.rlim_max};  // one of them was to count
    ::setrlimit(RLIMIT_NOFILE, &tight);
    EXPECT_EQ(acceptor->accept(), nullptr);
    ::setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_TRUE(client.wait([&] { return client.connection->loss() != Loss::None; }));
    const std::string why = client.connection->loss_text();
    EXPECT_TRUE(why.find("no file descriptors left (see `ulimit -n`)") != std::string::npos ||
                why.find("Too many open files") != std::string::npos)
        << left << ": " << why;
  }
  End client = connect();
  EXPECT_NE(wait_for_client(*acceptor), nullptr) << "later ones are let in";
}

TEST_F(ShmProcess, AClientForWhomNotEvenTheSpareDescriptorWasLeftIsLetInLater) {
  const auto acceptor = listen();
  End client = connect();
  // Also because UBSan looks with a pipe, which there is none of below, at objects it has not seen.
  EXPECT_FALSE(acceptor->short_of_descriptors());
  rlimit before{};
  ::getrlimit(RLIMIT_NOFILE, &before);
  const rlimit none{0, before.rlim_max};  // as when another thread was quicker
  ::setrlimit(RLIMIT_NOFILE, &none);
  EXPECT_EQ(acceptor->accept(), nullptr);
  EXPECT_TRUE(acceptor->short_of_descriptors());
  ::setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_NE(wait_for_client(*acceptor), nullptr);
  EXPECT_FALSE(acceptor->short_of_descriptors());
}

}  // namespace
}  // namespace gecos::media
