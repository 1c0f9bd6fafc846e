// Readable text for a failed system call.
#pragma once

#include <string>
#include <string_view>

namespace gecos {

/// "Permission denied"; where that helps with what to do about it. `error` is an errno.
std::string system_text(int error);

/// Throws std::system_error whose text begins with `what` was tried.
[[noreturn]] void throw_system_error(std::string_view what, int error);

}  // namespace gecos
