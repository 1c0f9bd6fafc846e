// The same test over every medium: what a session promises does not depend on it.
#pragma once

#include "bench.hpp"

namespace probe {

class OverMedia : public Bench, public ::testing::WithParamInterface<gecos::media::Kind> {
 protected:
  OverMedia() : Bench(GetParam()) {}
  void SetUp() override {
    Bench::SetUp();
    serve("PROBE", servant_);
  }
};

inline std::string name_of(const ::testing::TestParamInfo<gecos::media::Kind>& info) {
  return std::string(gecos::media::to_string(info.param));
}

}  // namespace probe

#define PROBE_OVER_MEDIA(suite)                                                              \
  INSTANTIATE_TEST_SUITE_P(Over, suite,                                                      \
                           ::testing::Values(gecos::media::Kind::Inproc,                     \
                                             gecos::media::Kind::Shm, gecos::media::Kind::Lcm), \
                           probe::name_of)
