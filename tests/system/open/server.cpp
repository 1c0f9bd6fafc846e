// Serves an object with an open stream: the C++ half of the servers in test_open_stream.py.
#include "barograph_server.hpp"
#include "gecos/gecos.hpp"

namespace {

weather::Reading reading(std::uint32_t number, std::uint32_t size) {
  weather::Reading made;
  made.number = number;
  made.place = {"Königstuhl", 0.862};
  made.trend = static_cast<weather::Trend>(number % 3);
  for (std::uint32_t i = 0; i < size; ++i) made.pressures.push_back(i / 4.0 + number);
  made.histogram = {1, 2, 65535};
  if (number % 2 == 0) made.remark = "calm";
  return made;
}

class Barograph final : public weather::BarographServant {
 public:
  gecos::Result<weather::Reading> readings() override { return reading(0, 0); }
  gecos::Result<weather::Reading> sealed() override { return reading(0, 0); }
  gecos::Result<void> record(std::uint32_t first, std::uint32_t times,
                             std::uint32_t size) override {
    for (std::uint32_t number = first; number < first + times; ++number) {
      publish_readings(reading(number, size));
      publish_sealed(reading(number, size));
    }
    return {};
  }
};

}  // namespace

int main(int, char** argv) {
  gecos::Lab lab;
  Barograph barograph;
  return gecos::serve(lab, {{argv[1], barograph, {.simulated = true}}});
}
