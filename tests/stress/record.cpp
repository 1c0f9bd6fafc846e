#include "record.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "../cpp/settles.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/session/process/termination_signals.hpp"

namespace stress {
namespace {

constexpr std::uint64_t prime = 0x100000001b3;  // of FNV-1a

std::uint64_t mix(std::uint64_t sum, std::uint8_t byte) { return (sum ^ byte) * prime; }

std::uint64_t begin_with(std::uint64_t command) {
  std::uint64_t sum = 0xcbf29ce484222325;
  for (int at = 0; at < 8; ++at) sum = mix(sum, static_cast<std::uint8_t>(command >> (8 * at)));
  return sum;
}

void say(const char* when, const Census& counted) {
  std::printf("%s %td %td %td\n", when, counted.descriptors, counted.threads, counted.memfds);
  std::fflush(stdout);
}

std::ptrdiff_t entries(const char* directory) {
  return std::distance(std::filesystem::directory_iterator(directory), {});
}

}  // namespace

Record::Record(const std::string& path)
    : file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600)) {
  if (file_ < 0) throw std::system_error(errno, std::generic_category(), path);
}

Record::~Record() { ::close(file_); }

void Record::note(const std::string& what) const {
  const auto now = gecos::SystemClock().since_boot().time_since_epoch();
  const std::string line = std::to_string(now.count()) + " " + what + "\n";
  if (::write(file_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    throw std::system_error(errno, std::generic_category(), "the record of this program");
  }
}

std::int64_t answer(std::uint64_t command, std::int64_t salt) {
  std::uint64_t sum = begin_with(command);
  for (int at = 0; at < 8; ++at) {
    sum = mix(sum, static_cast<std::uint8_t>(static_cast<std::uint64_t>(salt) >> (8 * at)));
  }
  return static_cast<std::int64_t>(sum);
}

std::int64_t answer(std::uint64_t command, std::span<const std::uint8_t> load) {
  std::uint64_t sum = begin_with(command);
  for (const std::uint8_t byte : load) sum = mix(sum, byte);
  return static_cast<std::int64_t>(sum);
}

Census census() {
  Census counted;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    if (line.find("memfd:") != std::string::npos) ++counted.memfds;
  }
  maps.close();
  counted.descriptors = entries("/proc/self/fd");
  counted.threads = entries("/proc/self/task");
  return counted;
}

Census Balance::at_first() {
  gecos::session::TerminationSignals::prepare();  // its descriptor stays the process's
  return census();
}

Balance::Balance() { say("before", before_); }

void Balance::close() const {
  Census now;
  settles([&] { return (now = census()) == before_; });
  say("after", now);
}

}  // namespace stress
