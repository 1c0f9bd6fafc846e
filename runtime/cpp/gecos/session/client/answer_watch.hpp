#pragma once

#include <cstdint>

#include "gecos/base/clock.hpp"

namespace gecos::session {

/// Detects a server that still sends heartbeats but no longer answers, because one of its threads
/// hangs or shared memory was damaged. Reads no clock: the caller passes the current time.
class AnswerWatch {
 public:
  AnswerWatch(Duration ask_after, Duration give_up_after, TimePoint now)
      : ask_after_(ask_after), give_up_after_(give_up_after), heard_at_(now), asked_at_(now) {}

  enum class Verdict : std::uint8_t {
    Fine,
    Ask,   ///< send a Query for each call that was open at the previous Ask
    Mute,  ///< calls are open, and no packet has come for `give_up_after`
  };
  /// `heard`: number of packets received from the server so far.
  Verdict judge(bool calls_are_open, std::uint64_t heard, TimePoint now) {
    if (!calls_are_open || heard != heard_) heard_at_ = now;
    heard_ = heard;
    if (!calls_are_open) asked_at_ = now;
    if (now - heard_at_ >= give_up_after_) return Verdict::Mute;
    if (now - asked_at_ < ask_after_) return Verdict::Fine;
    asked_at_ = now;
    return Verdict::Ask;
  }
  Duration silent_for(TimePoint now) const { return now - heard_at_; }

 private:
  const Duration ask_after_;
  const Duration give_up_after_;
  std::uint64_t heard_ = 0;
  TimePoint heard_at_;
  TimePoint asked_at_;
};

}  // namespace gecos::session
