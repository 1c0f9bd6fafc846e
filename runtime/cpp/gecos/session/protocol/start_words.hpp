#pragma once

#include <cstddef>
#include <cstdint>

#include "gecos/description.hpp"
#include "gecos/session/protocol/builtin.hpp"

namespace gecos::session {

/// The lane in which a call waits at the server until it starts.
enum class CallLane : std::uint8_t { None, Safety, Sensor, Actor };

}  // namespace gecos::session

/// Through words in shared memory (media::Connection::write_word), the server tells the client
/// which calls it has started, and the client tells the server which calls it has withdrawn. No
/// packets are needed, so each process can write while the other process is stopped.
///
/// Before the server starts a call, it writes the counter of the call: the *mark*. Before the
/// client reports how its calls ended, it writes the counter of its last call: the *withdrawal*.
/// After its own write, each side reads the other side's word. All four accesses are sequentially
/// consistent. If the client does not see the mark of a call, the server marks that call after the
/// withdrawal or never. A server that marks a call after the withdrawal sees the withdrawal and
/// does not start the call.
namespace gecos::session {

/// Index of the word that the client writes. No call whose counter is at most the value of this
/// word may start.
inline constexpr std::size_t withdrawn_word = 0;

/// Index of the word that the server writes for `lane`: the highest counter that was started in
/// this lane. The calls of one client start in the order of their counters, except calls whose
/// handlers run in parallel.
constexpr std::size_t marked_word(CallLane lane) { return static_cast<std::size_t>(lane); }

/// Returns a bit mask of the words that may contain the mark of a call of `operation`. Returns 0
/// for a built-in operation, which has no handler.
inline std::uint8_t marked_words(const OperationDescription& operation) {
  const auto bit = [](CallLane lane) { return static_cast<std::uint8_t>(1U << marked_word(lane)); };
  if (is_builtin(operation.code)) return 0;
  if (operation.safety) return bit(CallLane::Safety);
  if (operation.status != access::Status::Sensor) return bit(CallLane::Actor);
  const std::uint8_t sensor = bit(CallLane::Sensor);
  // An @ordered reading waits in the sensor or actor lane, depending on what its caller has queued.
  return operation.ordered ? sensor | bit(CallLane::Actor) : sensor;
}

}  // namespace gecos::session
