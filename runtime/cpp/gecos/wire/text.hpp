// What may be a string on the wire.
#pragma once

#include <string_view>

namespace gecos::wire {

/// Well-formed UTF-8 by RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF.
bool valid_utf8(std::string_view text);

/// May be sent as a string: UTF-8 without NUL.
bool valid_text(std::string_view text);

}  // namespace gecos::wire
