// Functions return expected failures as values of the type `tl::expected<T, E>`; E is a small type
// that says what failed. Only this header includes tl/expected.hpp, so that std::expected can
// replace that library.
#pragma once

#include <tl/expected.hpp>
