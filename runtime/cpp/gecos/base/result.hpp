// Expected failures are values: `tl::expected<T, E>` where E is a small enum with its evidence. No
// other header includes tl/expected.hpp, so that std::expected can replace it.
#pragma once

#include <tl/expected.hpp>
