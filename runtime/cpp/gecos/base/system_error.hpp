// Error texts and exceptions for system calls that failed.
#pragma once

#include <string>
#include <string_view>

namespace gecos {

/// Returns the text of the errno `error`, for example "Permission denied". Adds advice for the
/// errors of which the user can find the cause.
std::string system_text(int error);

/// Throws a std::system_error for the errno `error`. The text of the exception begins with `what`,
/// the name of the call that failed.
[[noreturn]] void throw_system_error(std::string_view what, int error);

}  // namespace gecos
