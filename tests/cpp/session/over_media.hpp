// The same test over every medium: what a session promises does not depend on it.
#pragma once

#include "../media/kind_names.hpp"
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

/// Two programs have a proxy of PROBE.
class TwoProxies : public OverMedia {
 protected:
  void SetUp() override {
    OverMedia::SetUp();
    holder = connect(lab_);
    other = connect(second_lab_);
  }
  Probe holder, other;
};

}  // namespace probe

#define PROBE_OVER_MEDIA(suite)                                                                   \
  INSTANTIATE_TEST_SUITE_P(Over, suite,                                                           \
                           ::testing::Values(gecos::media::Kind::Inproc, gecos::media::Kind::Shm, \
                                             gecos::media::Kind::Lcm),                            \
                           gecos::media::name_of)
