// A servant that sends its events when it is asked to.
#pragma once

#include "button_server.hpp"

namespace buttons {

class Sender : public AlarmServant {
 protected:
  gecos::Result<void> press(const std::string& who, double force, std::uint32_t times) override {
    for (std::uint32_t i = 0; i < times; ++i) publish_pressed({who, force});
    return {};
  }
  gecos::Result<void> lift(std::uint32_t times) override {
    for (std::uint32_t i = 0; i < times; ++i) publish_lifted({});
    return {};
  }
  gecos::Result<void> silence(std::int32_t zone) override {
    publish_silenced({zone});
    return {};
  }
};

}  // namespace buttons
