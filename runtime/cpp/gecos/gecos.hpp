#pragma once

/// Everything a program needs that uses or serves objects; the interfaces come from generated
/// headers.
#include "gecos/session/lab.hpp"
#include "gecos/session/reserved.hpp"
#include "gecos/session/server.hpp"
