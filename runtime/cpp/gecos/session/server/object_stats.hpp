#pragma once

#include "gecos/base/clock.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl

namespace gecos::session {

class ObjectCalls;
class ObjectHost;

/// Returns what `gecos stats` shows of `object`: its counts of calls, samples and clients since the
/// server began to serve it. `calls` are the calls of `object`. `now` is the current time of
/// Clock::now. The caller must hold the mutex of the object.
ObjectStats stats_of(ObjectHost& object, ObjectCalls& calls, TimePoint now);

}  // namespace gecos::session
