// What the code of a mistake may use: a broker, a server, and a table that turns.
#pragma once

#include <signal.h>
#include <sys/types.h>

#include <chrono>
#include <coroutine>
#include <exception>
#include <functional>
#include <future>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gecos/broker/broker.hpp"
#include "gecos/gecos.hpp"
#include "lab/table_client.hpp"
#include "lab/table_interface.hpp"
#include "lab/table_server.hpp"
#include "robcl/gripper_client.hpp"

using namespace std::chrono_literals;

/// A table that turns at once. A test may replace a handler by a mistake.
class Turntable : public lab::TableServant {
 public:
  std::function<gecos::Result<void>(double)> turns = [](double) { return gecos::Result<void>{}; };
  double weight = 1;  // kg
  using lab::TableServant::publish_angle;

 protected:
  gecos::Result<double> angle() override { return 0.0; }
  gecos::Result<double> load() override { return weight; }
  gecos::Result<void> turn(double to) override { return turns(to); }
  gecos::Result<void> lift(double) override { return {}; }
  gecos::Result<void> take(const lab::Pose&) override { return {}; }
  gecos::Result<void> set_speed(lab::Speed) override { return {}; }
  gecos::Result<void> approach(const lab::Goal&) override { return {}; }
  gecos::Result<void> label(const std::string&) override { return {}; }
  gecos::Result<void> program(const std::vector<std::uint8_t>&) override { return {}; }
  gecos::Result<void> spin(gecos::Execution<>& run) override {
    while (!run.wait_interrupted(1s)) {
    }
    return tl::unexpected(gecos::Fault::interrupted());
  }
};

/// A table that another process serves as FAR, over shm.
class FarTable {
 public:
  FarTable();
  ~FarTable() { kill(); }
  FarTable(const FarTable&) = delete;
  FarTable& operator=(const FarTable&) = delete;
  void kill();

 private:
  pid_t process_ = 0;
};

struct Bench {
  gecos::Lab& lab;
  gecos::Server& server;
  Turntable& servant;  ///< served as TABLE
  const lab::Table& table;
};

/// A coroutine that starts at once; `done` gives what it returned.
struct Sequence {
  struct promise_type {
    std::promise<std::string> result{};
    Sequence get_return_object() { return {result.get_future()}; }
    std::suspend_never initial_suspend() noexcept { return {}; }
    std::suspend_never final_suspend() noexcept { return {}; }
    void return_value(std::string text) { result.set_value(std::move(text)); }
    void unhandled_exception() { std::terminate(); }
  };
  std::future<std::string> done;
};

template <class T>
std::string text_of(const T& value) {
  std::ostringstream out;
  out << value;
  return std::move(out).str();
}

/// Prints what the user is told. Without it, the last line of stderr is what the user is told.
template <class T>
void say(const T& what) {
  std::cout << what << std::endl;
}

using MakeMistake = void (*)(Bench&);
extern const std::map<std::string, MakeMistake> mistakes;
