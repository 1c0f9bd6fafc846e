#pragma once

#include <cstddef>
#include <string_view>

namespace robcl::arm {

/// Returns whether elements of the text `xml` are nested more than `most` deep. A parser that calls
/// itself for each level would exhaust its stack. Also returns true if an element contains "<?",
/// because parsers differ in where this ends, and so in which tags follow. Other text that is not
/// well-formed is left to the parser.
bool nested_deeper_than(std::size_t most, std::string_view xml);

}  // namespace robcl::arm
