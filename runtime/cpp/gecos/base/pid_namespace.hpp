#pragma once

#include <cstdint>

namespace gecos {

/// Returns the inode number of the PID namespace of this process. Two processes of one machine that
/// get equal values see every process under the same PID. Returns 0 when the kernel does not tell
/// the inode.
std::uint64_t pid_namespace();

}  // namespace gecos
