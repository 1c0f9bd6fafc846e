#pragma once

#include <cstdint>

namespace gecos {

/// Returns the PID namespace of this process by its inode. Two processes of one machine with equal
/// values see each process under the same number. Returns 0 when the kernel does not tell it.
std::uint64_t pid_namespace();

}  // namespace gecos
