#pragma once

/// Includes all that a program needs to use or to serve objects, except the interfaces, which are
/// in generated headers.
#include "gecos/builtin_operations.hpp"
#include "gecos/lab.hpp"
#include "gecos/line.hpp"
#include "gecos/listener.hpp"
#include "gecos/object_watch.hpp"
#include "gecos/reconnecting.hpp"
#include "gecos/serve.hpp"
#include "gecos/server.hpp"
