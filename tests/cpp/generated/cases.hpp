#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/bytes.hpp"

/// The shared vectors of tests/vectors/types.json, written out in C++ by write_cpp_cases.py.
struct Case {
  const char* type;
  const char* name;
  const char* hex;                  ///< what it must become
  gecos::Bytes (*encode)();         ///< the value, encoded by generated code
  bool (*equals)(gecos::ByteView);  ///< decoded, and the value
  std::string (*print)();
};
const std::vector<Case>& cases();

/// What decoding says to `bytes` as a value of `type`: the value encoded again, or nothing and why.
struct Verdict {
  std::optional<gecos::Bytes> bytes;
  std::string why;
};
/// `decoded` is called between decoding and encoding.
Verdict judge(std::string_view type, gecos::ByteView bytes, void (*decoded)() = nullptr);

/// A type that can be judged. Decoding n bytes of it allocates at most memory_factor * n + 64 KiB.
struct JudgedType {
  const char* name;
  double memory_factor;
};
const std::vector<JudgedType>& judged_types();

gecos::Bytes from_hex(std::string_view hex);
std::string to_hex(gecos::ByteView bytes);
