#include "gecos/media/kinds.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <array>

#include "gecos/media/inproc/inproc.hpp"
#include "gecos/media/layers/transfer.hpp"
#include "gecos/media/testing/faulty.hpp"
#include "pair_medium.hpp"

namespace gecos::media {
namespace {

TEST(Kinds, AreFoundByTheirNamesAndAddresses) {
  for (const Kind kind : all_kinds()) {
    EXPECT_EQ(kind_from(to_string(kind)), kind);
    EXPECT_EQ(kind_of(std::string(to_string(kind)) + ":there"), kind);
  }
  EXPECT_EQ(kind_from("smoke"), std::nullopt);
  EXPECT_EQ(kind_of("smoke:there"), std::nullopt);
  EXPECT_EQ(kind_from(""), std::nullopt);
}

TEST(Kinds, TheShortestReachComesFirst) {
  EXPECT_TRUE(std::ranges::is_sorted(all_kinds(), {}, reach_of));
  EXPECT_TRUE(within_process(std::array{Kind::Inproc}));
  EXPECT_FALSE(within_process({}));
  EXPECT_FALSE(within_process(all_kinds()));
}

TEST(Kinds, AMediumThatOthersHearIsSealedAndEachCarriesWhatTheSessionSends) {
  for (const Kind kind : all_kinds()) {
    const auto opened = open(kind);
    ASSERT_TRUE(opened) << opened.error().text;
    const Capabilities& capabilities = (*opened)->capabilities();
    EXPECT_EQ(capabilities.name, to_string(kind));
    EXPECT_EQ(capabilities.reach, reach_of(kind));
    EXPECT_TRUE(capabilities.authenticated || !capabilities.overheard) << capabilities.name;
    EXPECT_TRUE(capabilities.intact) << capabilities.name;
    EXPECT_GE(capabilities.largest_packet, largest_transfer) << capabilities.name;
  }
}

TEST(Kinds, LayersAreChosenByWhatAMediumOffers) {
  const SystemClock clock;
  const auto whole = with_layers(make_inproc(), clock);
  EXPECT_EQ(whole->capabilities().largest_packet, inproc_capabilities.largest_packet)
      << "it needs none";
  EXPECT_TRUE(whole->capabilities().ordered);
  Faults damage;
  damage.corruption = 0.1;
  const auto checked = with_layers(make_faulty(make_inproc(), damage, clock), clock);
  EXPECT_TRUE(checked->capabilities().intact);
  EXPECT_EQ(checked->capabilities().largest_packet, inproc_capabilities.largest_packet - 4)
      << "a checksum";
  const auto small = with_layers(make_pair_medium(), clock);
  EXPECT_EQ(small->capabilities().largest_packet, largest_transfer) << "in pieces";
}

TEST(Open, HowFarLcmGoesIsANumberOfRouters) {
  for (const char* const right : {"", "0", "1", "255"}) {
    setenv("GECOS_LCM_TTL", right, 1);
    EXPECT_TRUE(open(Kind::Lcm)) << right;
  }
  for (const char* const wrong : {"-1", "256", "1 ", "far"}) {
    setenv("GECOS_LCM_TTL", wrong, 1);
    const auto opened = open(Kind::Lcm);
    ASSERT_FALSE(opened) << wrong;
    EXPECT_EQ(opened.error().text,
              "lcm: GECOS_LCM_TTL is '" + std::string(wrong) +
                  "'; it says how many routers a packet may pass, 0 (this host alone) to 255");
  }
  unsetenv("GECOS_LCM_TTL");
}

TEST(HostIdentity, TellsWhoSharesTheMachineAndTheMemory) {
  const std::string here = host_identity();
  EXPECT_TRUE(share_memory(here, here)) << here;
  EXPECT_TRUE(on_one_machine(here, here)) << here;
  EXPECT_FALSE(share_memory(here, here + "0"));
  EXPECT_TRUE(on_one_machine(here, here + "0")) << "another directory";
  EXPECT_FALSE(on_one_machine(here, "0" + here));
}

TEST(HostIdentity, ThatIsNotKnownIsThatOfNoOtherHost) {
  const char* const before = ::getenv("GECOS_RUNTIME_DIR");
  const std::string directory = before == nullptr ? "" : before;
  ASSERT_EQ(::setenv("GECOS_RUNTIME_DIR", "/proc/none", 1), 0);
  const std::string without_memory = host_identity();
  EXPECT_EQ(runtime_directory(), "");
  ASSERT_EQ(::setenv("GECOS_RUNTIME_DIR", directory.c_str(), 1), 0);
  EXPECT_FALSE(share_memory(without_memory, without_memory));
  EXPECT_TRUE(on_one_machine(without_memory, host_identity()));
  // What programs of other versions say when they cannot identify their host.
  for (const std::string unknown :
       {"", "/", "no shared memory: shm: cannot make /tmp/gecos-1000"}) {
    EXPECT_FALSE(share_memory(unknown, unknown)) << unknown;
    EXPECT_FALSE(on_one_machine(unknown, unknown)) << unknown;
  }
}

}  // namespace
}  // namespace gecos::media
