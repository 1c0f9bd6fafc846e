#pragma once

/// All that a program needs to use or to serve objects; the interfaces come from generated headers.
#include "gecos/builtin_operations.hpp"
#include "gecos/lab.hpp"
#include "gecos/reconnecting.hpp"
#include "gecos/serve.hpp"
#include "gecos/server.hpp"
