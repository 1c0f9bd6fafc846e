#pragma once

#include "gecos/base/clock.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl

namespace gecos::session {

class ObjectCalls;
class ObjectHost;

/// Returns the counts of `object` since the server began to serve it. `calls`: its calls; requires
/// the object's mutex. `now`: the current time of Clock::now.
ObjectStats stats_of(ObjectHost& object, ObjectCalls& calls, TimePoint now);

}  // namespace gecos::session
