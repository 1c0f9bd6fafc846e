// Readable text for a failed system call.
#pragma once

#include <string>
#include <string_view>

namespace gecos {

/// The text of the errno `error`, "Permission denied", with advice if there is some.
std::string system_text(int error);

/// Throws std::system_error for the errno `error`; its text begins with `what`, the failed call.
[[noreturn]] void throw_system_error(std::string_view what, int error);

}  // namespace gecos
