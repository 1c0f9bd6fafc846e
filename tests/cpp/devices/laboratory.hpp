// One process with a broker and devices, each served from a lab of its own, as if it were a
// program.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"

namespace devices {

/// Servants are members of the fixture that derives from this: they outlive their servers.
class Laboratory : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto served = broker_.serve(broker_server_, {gecos::media::Kind::Inproc});
    ASSERT_TRUE(served) << served.error().text;
  }
  void TearDown() override { stop_serving(); }
  /// For servants that end before the fixture.
  void stop_serving() { places_.clear(); }

  void serve(const std::string& name, gecos::Servant& servant) {
    gecos::ObjectOptions options;
    options.simulated = true;
    options.thread_safe = true;
    options.blocking = true;
    options.media = {gecos::media::Kind::Inproc};
    auto& place = places_.emplace_back(std::make_unique<Place>());
    const auto added = place->server.add(name, servant, std::move(options));
    ASSERT_TRUE(added) << added.error().text;
  }

  template <class Proxy>
  Proxy create(const std::string& name) {
    auto created = lab_.create<Proxy>(name);
    EXPECT_TRUE(created) << created.error();
    return created ? *created : Proxy();
  }

  /// What a command gives. Until it ends, `work` is done again and again: the devices' own loops.
  template <class Command, class Work>
  static auto get(const Command& command, Work work) {
    while (command.wait_for(std::chrono::microseconds(200)) == gecos::State::Running) work();
    return command.get();
  }

  gecos::Lab broker_lab_;
  gecos::broker::Broker broker_;
  gecos::Server broker_server_{broker_lab_};
  gecos::Lab lab_;

 private:
  struct Place {
    gecos::Lab lab;
    gecos::Server server{lab};
  };
  std::vector<std::unique_ptr<Place>> places_;
};

}  // namespace devices
