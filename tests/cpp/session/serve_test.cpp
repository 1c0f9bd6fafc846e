// Forks before it has threads: each test needs a process of its own, which ctest gives it.
#include "gecos/serve.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>
#include <thread>

#include "place.hpp"
#include "probe.hpp"

namespace gecos {
namespace {

bool handled(int signal) {
  struct sigaction now {};
  sigaction(signal, nullptr, &now);
  return now.sa_handler != SIG_DFL && now.sa_handler != SIG_IGN;
}

/// Of an object at a well-known address, which no other test may have at the same time.
ObjectOptions without_broker() {
  ObjectOptions options;
  options.well_known = true;
  return options;
}

TEST(Serve, ServesUntilASignalAndSaysWhenAClientCanCome) {
  const probe::Place place;
  const probe::BrokerHere broker;
  Lab lab;
  probe::ProbeServant servant;
  bool ended = false;
  ServeOptions options;
  options.program = "robcl-probe";
  std::thread client;
  options.started = [&] {
    client = std::thread([] {
      Lab other;
      EXPECT_EQ(other.create<probe::Probe>("PROBE")->read().get().value(), 7);
      kill(getpid(), SIGTERM);
    });
    return std::shared_ptr<void>(nullptr, [&](void*) { ended = true; });
  };
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(serve(lab, {{"PROBE", servant}}, options), 0);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "serving PROBE\n");
  EXPECT_TRUE(ended);
  EXPECT_FALSE(handled(SIGTERM)) << "the signals are the program's again";
  client.join();
}

TEST(Serve, ASignalEndsTheWaitForABroker) {
  const probe::Place place;
  Lab lab;
  probe::ProbeServant servant;
  std::thread user([] {
    while (!handled(SIGINT)) std::this_thread::yield();
    kill(getpid(), SIGINT);
  });
  ObjectOptions patient;
  patient.patience = std::chrono::hours(1);
  EXPECT_EQ(serve(lab, {{"PROBE", servant, patient}}), 0);
  user.join();
}

TEST(Serve, WithoutABrokerSaysWhatIsMissing) {
  const probe::Place place;
  Lab lab;
  probe::ProbeServant servant;
  ObjectOptions hasty;
  hasty.patience = std::chrono::milliseconds(1);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(serve(lab, {{"PROBE", servant, hasty}}, {.program = "robcl-probe"}), 1);
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(said.rfind("robcl-probe: PROBE is not served: ", 0), 0U) << said;
}

TEST(Serve, InsecureIsRefusedForAnObjectThatMayMoveHardware) {
  const probe::Place place;
  const probe::BrokerHere broker;
  Lab lab;
  probe::ProbeServant servant;
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(serve(lab, {{"PROBE", servant}}, {.admission = Admission::Insecure}), 1);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "PROBE is not served: --insecure admits every user of every host, and PROBE does not "
            "declare itself simulated; leave --insecure out and name the users in a lab file, or "
            "declare the object simulated if it moves no hardware\n");
}

TEST(Serve, InsecureSaysSoOnStderrAndToClients) {
  const probe::Place place;
  const probe::BrokerHere broker;
  Lab lab;
  probe::ProbeServant servant;
  std::string authentication;
  std::thread client;
  ServeOptions options{.admission = Admission::Insecure};
  options.started = [&] {
    client = std::thread([&] {
      Lab other;
      if (auto probe = other.create<probe::Probe>("PROBE")) {
        const auto about = describe(*probe).get();
        if (about) authentication = about->authentication;
      }
      kill(getpid(), SIGTERM);
    });
    return nullptr;
  };
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(serve(lab, {{"PROBE", servant, {.simulated = true}}}, options), 0);
  client.join();
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("\n* --insecure: PROBE admits every user of every host.\n"),
            std::string::npos)
      << said;
  EXPECT_NE(authentication.find("--insecure: every user of every host may connect"),
            std::string::npos)
      << authentication;
}

TEST(Serve, WhateverIsThrownIsOneLineAndTheStatusOfTheProgram) {
  const probe::Place place;
  Lab lab;
  for (const auto& [thrower, text] :
       std::vector<std::pair<std::function<std::shared_ptr<void>()>, std::string>>{
           {[]() -> std::shared_ptr<void> { throw std::runtime_error("no supply"); },
            "robcl-probe: no supply\n"},
           {[]() -> std::shared_ptr<void> { throw 7; },
            "robcl-probe: the program threw something that is not a std::exception\n"}}) {
    probe::ProbeServant servant;
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(serve(lab, {{"THROWN", servant, without_broker()}},
                    {.program = "robcl-probe", .started = thrower}),
              1);
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), text);
  }
}

TEST(Serve, TheSecondSignalEndsAProgramThatHangsWhileItEnds) {
  const probe::Place place;
  int says[2];
  ASSERT_EQ(pipe(says), 0);
  const pid_t child = fork();
  if (child == 0) {
    Lab lab;
    probe::ProbeServant servant;
    const auto say = [&](char what) { return write(says[1], &what, 1) == 1; };
    ServeOptions options;
    options.started = [&] {
      say('r');
      return std::shared_ptr<void>(nullptr, [&](void*) {
        say('e');
        for (;;) pause();
      });
    };
    _exit(serve(lab, {{"PROBE", servant, without_broker()}}, options));
  }
  char heard = 0;
  ASSERT_EQ(read(says[0], &heard, 1), 1);
  ASSERT_EQ(heard, 'r');
  kill(child, SIGTERM);
  ASSERT_EQ(read(says[0], &heard, 1), 1);
  ASSERT_EQ(heard, 'e');
  kill(child, SIGTERM);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
}

}  // namespace
}  // namespace gecos
