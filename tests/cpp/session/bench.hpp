// One process with a broker, a server and clients, each with a lab of its own.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>

#include "../settles.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"
#include "gecos/session/process/termination_signals.hpp"
#include "probe.hpp"

namespace probe {

/// Counted before the first member is made and after the last is gone: nothing may be left open.
class NothingLeftOpen : public ::testing::Test {
 public:
  ~NothingLeftOpen() override {
    // What was issued last may still be under way, and keeps its session until it has ended.
    EXPECT_TRUE(settles([this] { return open_now() <= before_; }))
        << open_now() - before_ << " descriptors were left open";
  }

 private:
  static std::ptrdiff_t open_at_first() {
    gecos::session::TerminationSignals::prepare();  // which the process keeps
    return open_now();
  }
  static std::ptrdiff_t open_now() {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  }
  const std::ptrdiff_t before_ = open_at_first();
};

/// Nobody loses a lease here because the machine was busy; what silence does is judged with a clock
/// of its own and by real processes (suspend_aware_clock_test, object_host_test, death_test).
inline gecos::LabOptions patient() {
  gecos::LabOptions options;
  options.lease_ttl = std::chrono::seconds(20);
  return options;
}

/// Ends in the order of real programs: clients, server, broker.
class Bench : public NothingLeftOpen {
 protected:
  explicit Bench(gecos::media::Kind kind = gecos::media::Kind::Inproc) : kind_(kind) {}

  void SetUp() override {
    const auto served = broker_.serve(broker_server_, {gecos::media::Kind::Inproc});
    ASSERT_TRUE(served) << served.error().text;
  }

  void serve(const std::string& name, ProbeServant& servant, bool thread_safe = true) {
    gecos::ObjectOptions options;
    options.simulated = true;
    options.thread_safe = thread_safe;
    options.media = {kind_};
    const auto added = server_->add(name, servant, std::move(options));
    ASSERT_TRUE(added) << added.error().text;
  }

  Probe connect(gecos::Lab& lab, const std::string& name = "PROBE") {
    gecos::CreateOptions options;
    options.medium = kind_;
    auto created = lab.create<Probe>(name, options);
    EXPECT_TRUE(created) << created.error();
    return created ? *created : Probe();
  }

  const gecos::media::Kind kind_;
  gecos::Lab broker_lab_;
  gecos::broker::Broker broker_;
  gecos::Server broker_server_{broker_lab_};
  ProbeServant servant_;
  gecos::Lab server_lab_{patient()};
  std::unique_ptr<gecos::Server> server_ = std::make_unique<gecos::Server>(server_lab_);
  gecos::Lab lab_{patient()};
  gecos::Lab second_lab_{patient()};
};

}  // namespace probe
