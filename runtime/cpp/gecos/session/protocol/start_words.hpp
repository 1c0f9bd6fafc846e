#pragma once

#include <cstddef>
#include <cstdint>

#include "gecos/description.hpp"
#include "gecos/session/protocol/builtin.hpp"

namespace gecos::session {

/// Where a call waits for its start at the server.
enum class CallLane : std::uint8_t { None, Safety, Sensor, Actor };

}  // namespace gecos::session

/// How client and server exchange starts and withdrawals through shared words
/// (media::Link::write_word), without a packet, so that neither needs the other to run.
///
/// The server writes the counter of a call before it starts it: the *mark*. The client writes the
/// counter of its last call before it reports how its calls ended: the *withdrawal*. Each then
/// reads the other's word. All four accesses are sequentially consistent: a call whose mark the
/// client does not see was marked after the withdrawal or never, and a server that marks after a
/// withdrawal sees it and does not start the call.
namespace gecos::session {

/// The client's word: no call up to this counter may start any more.
inline constexpr std::size_t withdrawn_word = 0;

/// The server's word: the highest counter that was started in this lane. Calls of one client start
/// there in the order of their counters, except handlers that run in parallel.
constexpr std::size_t marked_word(CallLane lane) { return static_cast<std::size_t>(lane); }

/// The words in which the mark of a call of `operation` may stand, one bit each. None for a
/// built-in operation, which has no handler.
inline std::uint8_t marked_words(const OperationDescription& operation) {
  const auto bit = [](CallLane lane) { return static_cast<std::uint8_t>(1U << marked_word(lane)); };
  if (is_builtin(operation.code)) return 0;
  if (operation.safety) return bit(CallLane::Safety);
  if (operation.status != access::Status::Sensor) return bit(CallLane::Actor);
  const std::uint8_t sensor = bit(CallLane::Sensor);
  // An ordered reading stands in either lane, depending on what its caller has queued.
  return operation.ordered ? sensor | bit(CallLane::Actor) : sensor;
}

}  // namespace gecos::session
