// Checks RAIL over the medium named: the C++ half of the pairs in test_pairs.py. Exits 0 when all
// held.

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "gecos/gecos.hpp"
#include "lab/rail_sensor_client.hpp"

using namespace std::chrono_literals;

namespace {

#define REQUIRE(condition)                                                       \
  if (!(condition)) {                                                            \
    std::cerr << __FILE__ << ':' << __LINE__ << ": not so: " #condition << '\n'; \
    std::exit(1);                                                                \
  }

template <class T>
T got(tl::expected<T, gecos::Failure> result, int line) {
  if (!result) {
    std::cerr << __FILE__ << ':' << line << ": " << result.error() << '\n';
    std::exit(1);
  }
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}
#define GOT(command) got((command).get(), __LINE__)

}  // namespace

int main(int argc, char** argv) {
  REQUIRE(argc == 2);
  const auto medium = gecos::media::kind_from(argv[1]);
  REQUIRE(medium);
  gecos::Lab lab;
  auto rail = lab.create<lab::RailSensor>("RAIL", {.medium = medium});
  if (!rail) {
    std::cerr << rail.error() << '\n';
    return 1;
  }
  auto lease = gecos::actor(*rail);
  if (!lease) {
    std::cerr << lease.error() << '\n';
    return 1;
  }

  GOT(rail->travel(0.0));
  REQUIRE(GOT(rail->measure()).value == 2.0);  // a call

  const auto too_far = rail->travel(10.0).get();  // a declared exception
  REQUIRE(!too_far);
  REQUIRE(too_far.error().detail == gecos::Detail::Fault);
  const auto end = too_far.error().as<lab::RailEnd>();
  REQUIRE(end && end->limit == 1.0);

  auto beam = rail->beam(gecos::stream);
  REQUIRE(beam);
  auto ride = rail->travel(1.0);
  double before = 2.0 + 1e-9;
  std::uint64_t sequence = 0;
  for (int i = 0; i < 20; ++i) {  // a stream, read while it moves
    const auto sample = beam->next(2s);
    REQUIRE(sample);
    REQUIRE(sample->sequence > sequence);
    REQUIRE(sample->value.value <= before);
    before = sample->value.value;
    sequence = sample->sequence;
  }
  const auto between = GOT(rail->measure());  // a sensor call is answered meanwhile
  REQUIRE(between.value < 2.0 && between.value > 1.0);
  REQUIRE(ride.state() == gecos::State::Running);
  const auto progress = ride.progress();
  REQUIRE(progress.detail == gecos::Detail::Executing);
  REQUIRE(progress.fraction > 0.0 && progress.fraction < 1.0);
  GOT(ride);
  REQUIRE(ride.state() == gecos::State::Finished);
  REQUIRE(GOT(rail->measure()).value == 1.0);

  GOT(rail->power(false));
  const auto dark = rail->measure().get();
  GOT(rail->power(true));
  REQUIRE(!dark && dark.error().as<robcl::SensorFault>());
  std::cout << "all held over " << argv[1] << std::endl;
}
