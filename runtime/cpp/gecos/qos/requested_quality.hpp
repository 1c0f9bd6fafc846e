#pragma once

#include "gecos/qos/quality.hpp"

namespace gecos::qos {

/// The quality that a program requests of one object at `create`, in addition to the `@qos` of the
/// interface. Each operation and each stream of the object then has the stricter of the declared
/// and the requested value of each term. The default values request nothing.
///
/// `start_by`, `depth` and the lifespan of inward streams cannot be requested, because the server
/// applies these terms and takes them from the interface. CreateOptions has members of their own
/// for the latency and the medium.
struct RequestedQuality {
  /// The class that the medium must have. With SoftRealtime or HardRealtime, each `latency` that
  /// the interface declares limits the round trip.
  Class line = Class::TimeIndependent;
  /// Reliable: the samples of streams, events and inward streams demand a medium over which none is
  /// lost on its way. Calls have this anyway.
  Reliability reliability = Reliability::Default;
  /// The longest time of a call from sending to completion, and the longest gap between two samples
  /// of a stream or event. The built-in operations have no deadline.
  Duration deadline{};
  /// The age above which a sample of a stream or event is not returned.
  Duration lifespan{};
  /// Acts on streams and events that have a deadline.
  Liveliness liveliness = Liveliness::Automatic;
};

/// Returns `declared`, the quality of an interface, operation or stream, with each term that
/// `requested` makes stricter. A looser request changes nothing. A requested time requests nothing
/// if it is zero, negative or longer than a century.
Quality stricter(const Quality& declared, const RequestedQuality& requested);

}  // namespace gecos::qos
