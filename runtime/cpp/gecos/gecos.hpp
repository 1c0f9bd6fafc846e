#pragma once

/// Everything a program needs that uses or serves objects; the interfaces come from generated
/// headers.
#include "gecos/lab.hpp"
#include "gecos/reserved.hpp"
#include "gecos/server.hpp"
