// The short form of the fuzzers, for any compiler: the inputs of ./inputs, some of which found
// something, and drawn ones that are the same each time.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "gecos/base/log.hpp"
#include "targets.hpp"

namespace gecos::fuzz {
namespace {

struct Target {
  const char* name;
  void (*run)(ByteView);
  int drawn;  ///< inputs, as many as a few seconds have time for
};

void PrintTo(const Target& target, std::ostream* out) { *out << target.name; }

class FixedInputs : public testing::TestWithParam<Target> {
 protected:
  void SetUp() override {
    set_log_level(LogLevel::Error);
  }  // of each hostile peer there is a warning
};

TEST_P(FixedInputs, KeepWhatIsPromisedWhateverTheOtherSideDoes) {
  std::mt19937_64 random(2026);
  for (int i = 0; i < GetParam().drawn; ++i) {
    Bytes input(8 + random() % 600);
    for (std::byte& byte : input) byte = static_cast<std::byte>(random());
    GetParam().run(input);
  }
}

TEST_P(FixedInputs, OfThisFolderFindNothing) {
  const std::filesystem::path folder = std::filesystem::path(GECOS_INPUTS) / GetParam().name;
  int inputs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    ASSERT_FALSE(text.empty()) << entry.path();
    GetParam().run(std::as_bytes(std::span(text)));
    ++inputs;
  }
  EXPECT_GT(inputs, 0) << folder;
}

INSTANTIATE_TEST_SUITE_P(Of, FixedInputs,
                         testing::Values(Target{"rings", try_rings, 8000},
                                         Target{"packets", try_packets, 6000},
                                         Target{"samples", try_samples, 8000},
                                         Target{"datagrams", try_datagrams, 4000}),
                         [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace gecos::fuzz
