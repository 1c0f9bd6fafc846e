#pragma once

#include <cstdint>
#include <string_view>

#include "gecos/base/clock.hpp"

/// What a line is asked to be: the values of `@qos`, inherited and narrowed by the compiler.
namespace gecos::qos {

enum class Class : std::uint8_t { TimeIndependent, SoftRealtime, HardRealtime };
enum class Reliability : std::uint8_t { Reliable, BestEffort };
std::string_view to_string(Class line);  ///< "HARD_REALTIME", as in the interface
std::string_view to_string(Reliability reliability);

/// A duration of zero means: not asked.
struct Quality {
  Class line = Class::TimeIndependent;
  Reliability reliability = Reliability::Reliable;
  Duration deadline{};
  Duration start_by{};
  Duration latency{};
  Duration lifespan{};
  std::uint32_t depth = 0;
  bool shm_only_media = false;  ///< `media` names no medium between hosts ("shm", "shm|can")
};

}  // namespace gecos::qos
