#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "gecos/base/clock.hpp"

/// Required quality of service: the values of `@qos`, after gidl has combined them with the
/// inherited values.
namespace gecos::qos {

enum class Class : std::uint8_t { TimeIndependent, SoftRealtime, HardRealtime };
enum class Reliability : std::uint8_t {
  Default,     ///< Reliable for a call, BestEffort for the samples of a stream
  Reliable,    ///< demands a medium over which nothing is lost on its way
  BestEffort,  ///< demands nothing
};
/// What an operation or a stream sends over a medium. The samples of events and of inward streams
/// are samples, too.
enum class Traffic : std::uint8_t { Calls, Samples };
/// What happens to a session whose connection exceeds the latency that its interface demands.
enum class OnDegraded : std::uint8_t {
  Event,     ///< the session goes on; LineWatch reports the change
  Fail,      ///< the session is lost
  Failover,  ///< the proxy goes on over another medium that meets the quality, if there is one
};
/// The evidence that shows that the writer of a stream is alive: heartbeats of its process, or
/// samples of the writer itself.
enum class Liveliness : std::uint8_t { Automatic, Manual };
std::string_view to_string(Class line);  ///< for example "HARD_REALTIME", as in the interface
/// Returns whether `asked` demands that `traffic` is not lost on its way.
bool demands_reliable(Reliability asked, Traffic traffic);

/// The media that an operation or stream may use. For example, `media="shm|can"` in an interface is
/// `Media::Shm | Media::Can`.
enum class Media : std::uint8_t { Any = 0, Inproc = 1, Shm = 2, Lcm = 4, Tcp = 8, Can = 16 };
constexpr Media operator|(Media left, Media right) {
  return static_cast<Media>(static_cast<std::uint8_t>(left) | static_cast<std::uint8_t>(right));
}
std::string to_string(Media media);  ///< for example "shm|can", as in the interface; "any" for Any
/// Returns whether `media` contains the medium called `name`. Wherever shm is allowed, inproc is
/// allowed too, because it is at least as good.
bool allows(Media media, std::string_view name);

/// A required quality of service. A duration of zero means: no requirement.
struct Quality {
  Class line = Class::TimeIndependent;
  Reliability reliability = Reliability::Default;
  Duration deadline{};
  Duration start_by{};
  Duration latency{};
  Duration lifespan{};
  Liveliness liveliness = Liveliness::Automatic;
  std::uint32_t depth = 0;
  Media media = Media::Any;
  OnDegraded on_degraded = OnDegraded::Event;  ///< of an interface
};

/// Returns whether `asked` limits the latency. Its `latency` is a limit only with the class
/// SOFT_REALTIME or HARD_REALTIME.
inline bool binds_latency(const Quality& asked) {
  return asked.line != Class::TimeIndependent && asked.latency > Duration{};
}

}  // namespace gecos::qos
