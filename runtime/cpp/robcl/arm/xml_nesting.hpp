#pragma once

#include <cstddef>
#include <string_view>

namespace robcl::arm {

/// Returns whether elements of the text `xml` are nested more than `most` deep. A parser that calls
/// itself for each level would exhaust its stack. Also returns true if an element contains "<?",
/// because parsers disagree where such an instruction ends, and thus which tags follow. All other
/// errors in the text are left to the parser.
bool nested_deeper_than(std::size_t most, std::string_view xml);

}  // namespace robcl::arm
