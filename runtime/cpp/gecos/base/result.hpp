// Expected failures are values: `tl::expected<T, E>` with a small enum, and its evidence, as E.
// The one place that names where it comes from, so that std::expected can take over.
#pragma once

#include <tl/expected.hpp>
