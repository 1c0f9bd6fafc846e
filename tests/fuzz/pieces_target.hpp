#pragma once

#include "script.hpp"

namespace gecos::fuzz {

/// A line that carries large packets in pieces, whose peer sends pieces and answers as it likes.
void try_pieces(Script script);

}  // namespace gecos::fuzz
