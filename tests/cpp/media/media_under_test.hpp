#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gecos/media/medium.hpp"
#include "gecos/media/waiting.hpp"
#include "scratch_directory.hpp"

namespace gecos::media {

inline std::size_t open_descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

/// While it lives this process can open nothing more.
class NoDescriptorLeft {
 public:
  NoDescriptorLeft() {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit tight{open_descriptors() - 1, before_.rlim_max};  // one of them was to count
    ::setrlimit(RLIMIT_NOFILE, &tight);
    for (int one = 0; one >= 0;) {
      one = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
      if (one >= 0) gaps_.push_back(one);
    }
  }
  ~NoDescriptorLeft() {
    ::setrlimit(RLIMIT_NOFILE, &before_);
    for (const int one : gaps_) ::close(one);
  }
  NoDescriptorLeft(const NoDescriptorLeft&) = delete;
  NoDescriptorLeft& operator=(const NoDescriptorLeft&) = delete;

 private:
  rlimit before_{};
  std::vector<int> gaps_;
};

/// While it lives this process can map no more than `room` bytes.
class LittleAddressSpace {
 public:
  explicit LittleAddressSpace(std::size_t room) {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    ::getrlimit(RLIMIT_AS, &before_);
    const rlimit tight{pages * static_cast<std::size_t>(::getpagesize()) + room, before_.rlim_max};
    ::setrlimit(RLIMIT_AS, &tight);
  }
  ~LittleAddressSpace() { ::setrlimit(RLIMIT_AS, &before_); }
  LittleAddressSpace(const LittleAddressSpace&) = delete;
  LittleAddressSpace& operator=(const LittleAddressSpace&) = delete;

 private:
  rlimit before_{};
};

/// Nothing in these tests waits this long; who does has lost a wake-up.
inline TimePoint too_late() { return std::chrono::steady_clock::now() + std::chrono::seconds(20); }

/// One end of a connection, waited on as its users do. `acceptor` is the acceptor whose descriptors
/// and accept() feed it too, if any.
class End {
 public:
  explicit End(std::unique_ptr<Connection> of, Acceptor* acceptor = nullptr)
      : connection(std::move(of)), acceptor_(acceptor) {}

  /// Waits until `done`, looking again whenever something woke us. False: too late.
  bool wait(const std::function<bool()>& done) {
    for (;;) {
      if (done()) return true;
      bool in_time = true;
      if (connection->prepare_to_sleep()) {
        std::vector<int> all(connection->descriptors().begin(), connection->descriptors().end());
        if (acceptor_ != nullptr) {
          all.insert(all.end(), acceptor_->descriptors().begin(), acceptor_->descriptors().end());
        }
        in_time = sleep_on(all, too_late()) != Wake::TimedOut;
        connection->woke();
      }
      if (acceptor_ != nullptr) {
        while (auto another = acceptor_->accept()) others.push_back(std::move(another));
      }
      if (!in_time) {
        ADD_FAILURE() << "nobody woke us; it is " << (done() ? "done" : "not done");
        return false;
      }
    }
  }
  /// The next packet, as text. "(nothing)" when none came in time or the connection was lost.
  std::string receive() {
    std::string got = "(nothing)";
    wait([&] {
      if (const auto packet = connection->receive()) {
        got.assign(reinterpret_cast<const char*>(packet->data()), packet->size());
        return true;
      }
      if (connection->loss() == Loss::None) return false;
      if (const auto packet = connection->receive()) {  // sent before the loss
        got.assign(reinterpret_cast<const char*>(packet->data()), packet->size());
      }
      return true;
    });
    return got;
  }
  tl::expected<std::uint64_t, SendProblem> send(std::string_view text) {
    const ByteView bytes = std::as_bytes(std::span(text.data(), text.size()));
    return connection->send(bytes.first(bytes.size() / 2), bytes.subspan(bytes.size() / 2));
  }
  Loss wait_for_loss() {
    wait([&] { return connection->loss() != Loss::None; });
    return connection->loss();
  }
  std::unique_ptr<StreamReader> wait_for_stream(std::uint32_t id) {
    std::unique_ptr<StreamReader> reader;
    wait([&] {
      reader = connection->open_stream(id);
      return reader != nullptr || connection->loss() != Loss::None;
    });
    return reader;
  }

  std::unique_ptr<Connection> connection;
  std::vector<std::unique_ptr<Connection>> others;  ///< that came while we waited

 private:
  Acceptor* acceptor_;
};

/// Waits until `done`, while both ends do what maintenance would: on lcm what got lost is
/// said again with every beat. False: too late.
inline bool wait_ticking(End& one, End& other, const std::function<bool()>& done) {
  const TimePoint end = too_late();
  for (;;) {
    if (done()) return true;
    const TimePoint now = std::chrono::steady_clock::now();
    if (now >= end) return false;
    for (Connection* connection : {one.connection.get(), other.connection.get()}) {
      connection->beat();
      connection->beats_seen();
    }
    sleep_on(one.connection->descriptors(),
             std::min<TimePoint>(end, now + std::chrono::milliseconds(20)));
  }
}

/// A port for what everybody knows, of this process: below those that the kernel gives to sockets
/// that ask for none, and those that lcm draws.
inline std::uint16_t port_of_this_process() {
  return static_cast<std::uint16_t>(10'000 + ::getpid() % 10'000);
}

/// The next client of `acceptor`, waited for. Null when none came in time.
inline std::unique_ptr<Connection> wait_for_client(Acceptor& acceptor) {
  for (;;) {
    if (auto connection = acceptor.accept()) return connection;
    if (sleep_on(acceptor.descriptors(), too_late()) == Wake::TimedOut) return acceptor.accept();
  }
}

/// The same where the client has to do its part, as maintenance would: on lcm it proves its
/// key.
inline std::unique_ptr<Connection> wait_for_client(Acceptor& acceptor, Connection& client) {
  const TimePoint end = too_late();
  while (client.loss() == Loss::None) {
    client.beat();
    if (auto connection = acceptor.accept()) return connection;
    const TimePoint now = std::chrono::steady_clock::now();
    if (now >= end) break;
    std::vector<int> all(acceptor.descriptors().begin(), acceptor.descriptors().end());
    all.insert(all.end(), client.descriptors().begin(), client.descriptors().end());
    sleep_on(all, std::min<TimePoint>(end, now + std::chrono::milliseconds(20)));
  }
  ADD_FAILURE() << "no client came: " << client.loss_text();
  return nullptr;
}

inline ByteView bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}
inline std::string text_of(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace gecos::media
