// What lies between a client and a server of a schedule: a clock, packets on their way, words.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <functional>
#include <iostream>
#include <optional>

#include "gecos/media/medium.hpp"

namespace gecos::session::schedules {

/// One defect that a run must find. It stands in the line or in the driver: the runtime is the real
/// one.
enum class Mutant : std::uint8_t {
  None,
  WithdrawalReadBeforeMark,  ///< the server looks whether a call is withdrawn, and then marks it
  WithdrawalForgotten,       ///< the client reports the ends and withdraws nothing
  PauseForgotten,            ///< the server's clock stands while the server does
  ClosingIsGoodbye,          ///< a connection that closes without a word lets the queue go on
};

/// A frame that is older when it is read says nothing of its sender's life now, as over lcm.
inline constexpr Duration oldest_sign_of_life = std::chrono::milliseconds(250);

enum class Side : std::uint8_t { Client, Server };
constexpr Side other(Side side) { return side == Side::Client ? Side::Server : Side::Client; }

/// Random numbers that are the same everywhere (splitmix64).
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  std::uint64_t below(std::uint64_t end) { return next() % end; }
  bool one_in(std::uint64_t times) { return below(times) == 0; }
  /// Between the two, as often in each power of ten.
  Duration between(Duration shortest, Duration longest);

 private:
  std::uint64_t next();
  std::uint64_t state_;
};

/// With SCHEDULES_TRACE set, says on stderr what happens.
class Trace {
 public:
  template <class... What>
  void operator()(TimePoint now, What... what) const {
    if (!on_) return;
    std::cerr << std::chrono::duration<double>(now.time_since_epoch()).count() - 3600;
    ((std::cerr << ' ' << what), ...);
    std::cerr << '\n';
  }

 private:
  const bool on_ = std::getenv("SCHEDULES_TRACE") != nullptr;
};

/// Time of a schedule. Reading what pauses are judged by is a point at which a process may stop.
class ScheduleClock final : public Clock {
 public:
  TimePoint now() const override { return now_; }
  TimePoint since_boot() const override;
  Duration unix_time() const override { return {}; }

  /// Likewise, of nobody who could stop there.
  TimePoint seen_by_server() const { return now_ - hidden_; }

  void advance(Duration step) { now_ += step; }
  /// The server stood still for so long and cannot know (Mutant::PauseForgotten).
  void hide_from_server(Duration step) { hidden_ += step; }
  std::function<void()> after_reading;

 private:
  TimePoint now_{std::chrono::hours(1)};
  Duration hidden_{};
};

enum class Way : std::uint8_t {
  Memory,  ///< two processes that share memory: in order, nothing lost, words, deaths are reported
  Inside,  ///< one process: likewise
  Radio,   ///< loses, delays and so reorders; nobody tells of a death
};

/// Both ends of one connection, and whether the processes at them live.
class Line {
 public:
  Line(Way way, Mutant mutant, ScheduleClock& clock, Dice& dice);

  std::unique_ptr<media::Connection> connection(Side side);
  Way way() const { return way_; }
  /// Nothing that it does has an effect any more.
  void kill(Side side) { ends_[index(side)].dead = true; }
  bool dead(Side side) const { return ends_[index(side)].dead; }
  /// What is on its way to that side is lost.
  void forget(Side side) { ends_[index(side)].coming.clear(); }
  /// Nothing comes through until then; of a radio.
  void cut_until(TimePoint when) { cut_until_ = when; }
  /// The server has answered a goodbye, and the client knows.
  bool goodbye_heard() const { return ends_[index(Side::Client)].goodbye; }

  /// Called wherever an end touches what the other sees.
  std::function<void(Side)> touched;
  /// Called where the server reads a goodbye.
  std::function<void()> parting;

 private:
  friend class LineEnd;

  enum class Kind : std::uint8_t { Packet, Beat, Bye };
  struct Frame {
    Kind kind;
    Bytes packet;
    TimePoint sent;
    TimePoint arrives;
  };
  struct End {
    std::deque<Frame> coming;
    std::deque<Frame> arrived;
    Frame current{};
    std::array<std::uint64_t, media::shared_word_count> words{};
    std::uint64_t sent = 0;
    std::uint64_t taken = 0;
    std::uint64_t beats = 0;  ///< of the other, seen here
    bool closed = false;
    bool other_closed = false;
    bool goodbye = false;  ///< has been read
    bool dead = false;
    /// Of a mutant: written after the withdrawal was read.
    std::optional<std::pair<std::size_t, std::uint64_t>> late_mark;
  };
  static std::size_t index(Side side) { return static_cast<std::size_t>(side); }
  void put(Side from, Kind kind, Bytes packet);
  void pump(Side at);

  const Way way_;
  const Mutant mutant_;
  ScheduleClock& clock_;
  Dice& dice_;
  std::array<End, 2> ends_;
  TimePoint cut_until_{};
};

}  // namespace gecos::session::schedules
