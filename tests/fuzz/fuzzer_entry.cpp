// libFuzzer's entry into one of targets.hpp, which the build names.
#include <cstdint>
#include <span>

#include "gecos/base/log.hpp"
#include "targets.hpp"

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  gecos::set_log_level(gecos::LogLevel::Error);  // of each hostile peer there is a warning
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  gecos::fuzz::GECOS_FUZZED(std::as_bytes(std::span(data, size)));
  return 0;
}
