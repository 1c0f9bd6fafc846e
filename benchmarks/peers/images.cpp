#include "images.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <vector>

namespace peers::images {
namespace {

constexpr std::chrono::milliseconds pace{5};

std::int64_t now() { return std::chrono::nanoseconds(Clock::now().time_since_epoch()).count(); }

/// Reads every octet: each must equal the one before. memcmp takes no longer than to get them.
bool of_one_image(const std::uint8_t* octets, const Stamps& stamps) {
  const std::uint8_t* const first = octets + sizeof stamps;
  const auto rest = size - sizeof stamps;
  return *first == static_cast<std::uint8_t>(stamps.number) &&
         std::memcmp(first, first + 1, rest - 1) == 0;
}

void images(Reader& reader, Seconds how_long) {
  std::vector<Nanoseconds> readable, whole, sending;
  std::uint64_t number = 0;
  std::size_t lost = 0;
  const std::int64_t asked = now();
  const auto end = Clock::now() + how_long;
  while (readable.empty() ? lost < 10 : Clock::now() < end) {
    const std::uint8_t* const octets = reader.next();
    const std::int64_t arrived = now();
    Stamps stamps;
    std::memcpy(&stamps, octets, sizeof stamps);
    const bool same = of_one_image(octets, stamps);
    const std::int64_t read = now();
    if (!reader.intact()) {
      ++lost;
      continue;
    }
    if (!same) throw std::runtime_error("the octets are not those of one image");
    if (stamps.number <= number) throw std::runtime_error("an image came twice");
    number = stamps.number;
    if (stamps.begun < asked) continue;  // it may have waited here for the question
    readable.emplace_back(arrived - stamps.sent);
    whole.emplace_back(read - stamps.begun);
    if (stamps.sending != 0) sending.emplace_back(stamps.sending);
  }
  if (lost > readable.size() / 10 + 1) throw std::runtime_error("images were overwritten");
  const auto clock = of_the_clock();
  const auto figure = [&](std::vector<Nanoseconds>& times, double part) {
    return times.empty() ? 0.0 : (quantile(times, part) - clock).count();
  };
  std::printf("%zu %.1f %.1f %.1f %.1f %.1f\n", readable.size(), figure(readable, 0.5),
              figure(readable, 0.99), figure(whole, 0.5), figure(whole, 0.99),
              figure(sending, 0.5));
}

void answer(Reader& reader, const std::string& line) {
  std::istringstream words(line);
  std::string word;
  double seconds = 0;
  words >> word >> seconds;
  if (word != "images" || !(seconds > 0)) {
    throw std::invalid_argument("asked for \"" + line + "\"; images.hpp says what can be asked");
  }
  images(reader, Seconds(seconds));
}

}  // namespace

void Camera::begin() {
  // After an image that took longer than the pace, the next one is due at once.
  due_ = std::max(due_ + pace, Clock::now());
  std::this_thread::sleep_until(due_);
  stamps_.begun = now();
  ++stamps_.number;
}

void Camera::write(std::uint8_t* octets) {
  std::memset(octets + sizeof stamps_, static_cast<int>(stamps_.number & 0xff),
              size - sizeof stamps_);
  stamps_.sent = now();
  std::memcpy(octets, &stamps_, sizeof stamps_);
}

bool wanted(int argc, char** argv) {
  return argc > 2 && std::string_view(argv[2]).substr(0, 6) == "images";
}

int speak(
    int argc, char** argv, const std::function<void(const std::string&)>& serve,
    const std::function<std::unique_ptr<Reader>(const std::string&, const std::string&)>& connect) {
  return speak_lines(argc, argv, serve, [&](const std::string& how, const std::string& address) {
    const std::shared_ptr<Reader> reader = connect(how, address);
    return [reader](const std::string& line) { answer(*reader, line); };
  });
}

}  // namespace peers::images
