#pragma once

#include <cstdint>

namespace gecos::session {

/// What a broker answers to a program that asks for a session. Refused: the broker does not admit
/// this program. Other: the broker gave another answer, or no answer.
enum class BrokerAnswer : std::uint8_t { Other, Refused };

}  // namespace gecos::session
