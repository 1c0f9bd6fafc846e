// Generated C++ beside lcm-gen's and beside memcpy. Short bursts of all candidates take turns, so
// that what is compared stands in the same few microseconds; README.md says how to read the table.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "gecos/wire/contents.hpp"
#include "theirs/values/Doubles.hpp"
#include "theirs/values/PoseOfNumbers.hpp"
#include "values_types.hpp"

namespace {

using Nanoseconds = std::chrono::duration<double, std::nano>;

constexpr std::size_t count = 1000;
constexpr Nanoseconds burst = std::chrono::microseconds(20);

/// The compiler must believe that somebody looks at it, and that it may have changed.
template <class T>
void seen(T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

template <class Value>
Value pose() {
  Value value;
  value.x = 0.1, value.y = 0.2, value.z = 0.3;
  value.qw = 0.5, value.qx = 0.5, value.qy = -0.5, value.qz = 0.5;
  return value;
}

values::Doubles our_doubles() {
  values::Doubles value;
  value.numbers.resize(count);
  std::iota(value.numbers.begin(), value.numbers.end(), 0.5);
  return value;
}

theirs::values::Doubles lcm_doubles() {
  theirs::values::Doubles value;
  value.numbers_n = static_cast<std::int32_t>(count);
  value.numbers = our_doubles().numbers;
  return value;
}

using Work = std::function<void(int times)>;

/// Into a buffer that is there, as both write messages: fingerprint, then the fields.
template <class Value>
Work encode_ours(Value value) {
  gecos::Bytes bytes(gecos::wire::fingerprint_size + value.encoded_size());
  return [value, bytes](int times) mutable {
    for (; times > 0; --times) {
      seen(value);
      gecos::wire::Encoder to(bytes);
      to.put(Value::fingerprint());
      value.encode(to);
      seen(*bytes.data());
    }
  };
}

template <class Value>
Work decode_ours(const Value& from_this) {
  return [bytes = gecos::wire::to_message(from_this), value = Value{}](int times) mutable {
    for (; times > 0; --times) {
      seen(*bytes.data());
      gecos::wire::Decoder from(bytes);
      std::int64_t fingerprint = 0;
      const bool decoded = from.get(fingerprint) && fingerprint == Value::fingerprint() &&
                           value.decode(from) && from.expect_end();
      if (!decoded) std::abort();
      seen(value);
    }
  };
}

template <class Value>
std::vector<std::uint8_t> lcm_message(const Value& value) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(value.getEncodedSize()));
  value.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

template <class Value>
Work encode_lcm(Value value) {
  return [value, bytes = lcm_message(value)](int times) mutable {
    for (; times > 0; --times) {
      seen(value);
      if (value.encode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) std::abort();
      seen(*bytes.data());
    }
  };
}

template <class Value>
Work decode_lcm(const Value& from_this) {
  return [bytes = lcm_message(from_this), value = Value{}](int times) mutable {
    for (; times > 0; --times) {
      seen(*bytes.data());
      if (value.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) std::abort();
      seen(value);
    }
  };
}

/// Position of the numbers of a message: after the fingerprint and their count.
Work copy_doubles() {
  return [from = our_doubles().numbers,
          to = gecos::Bytes(12 + count * sizeof(double))](int times) mutable {
    for (; times > 0; --times) {
      seen(*from.data());
      std::memcpy(to.data() + 12, from.data(), from.size() * sizeof(double));
      seen(*to.data());
    }
  };
}

Nanoseconds time_of(const Work& work, int times) {
  const auto before = std::chrono::steady_clock::now();
  work(times);
  return (std::chrono::steady_clock::now() - before) / static_cast<double>(times);
}

/// Runs of about one burst.
int times_in_burst(const Work& work) {
  int times = 1;
  while (time_of(work, times) * times < burst) times *= 2;
  return times;
}

template <class T>
T at_quantile(std::vector<T>& values, double quantile) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(static_cast<double>(values.size() - 1) * quantile)];
}

struct Candidate {
  std::string name;
  Work work;
};

/// A row for each candidate; the first is ours.
void compare(const std::string& what, const std::vector<Candidate>& candidates, int rounds) {
  std::vector<int> times;
  for (const Candidate& each : candidates) times.push_back(times_in_burst(each.work));
  std::vector<std::vector<double>> measured(candidates.size());
  std::vector<std::vector<double>> ratios(candidates.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      measured[i].push_back(time_of(candidates[i].work, times[i]).count());
      ratios[i].push_back(measured[i].back() / measured[0].back());
    }
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    std::printf("| %s | %s | %.1f | %.2f | %.2f to %.2f |\n", what.c_str(),
                candidates[i].name.c_str(), at_quantile(measured[i], 0.5),
                at_quantile(ratios[i], 0.5), at_quantile(ratios[i], 0.25),
                at_quantile(ratios[i], 0.75));
  }
}

}  // namespace

int main(int given, char** arguments) {
  const int rounds = given > 1 ? std::atoi(arguments[1]) : 2001;
  const auto ours = pose<values::PoseOfNumbers>();
  const auto theirs = pose<theirs::values::PoseOfNumbers>();
  std::printf("| C++ | | p50 ns | x ours | half of the rounds |\n|---|---|--:|--:|--:|\n");
  compare("encode pose", {{"ours", encode_ours(ours)}, {"lcm-gen", encode_lcm(theirs)}}, rounds);
  compare("decode pose", {{"ours", decode_ours(ours)}, {"lcm-gen", decode_lcm(theirs)}}, rounds);
  compare("encode 1000 doubles",
          {{"ours", encode_ours(our_doubles())},
           {"lcm-gen", encode_lcm(lcm_doubles())},
           {"memcpy", copy_doubles()}},
          rounds);
  compare("decode 1000 doubles",
          {{"ours", decode_ours(our_doubles())},
           {"lcm-gen", decode_lcm(lcm_doubles())},
           {"memcpy", copy_doubles()}},
          rounds);
}
