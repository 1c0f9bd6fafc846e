// Reads lines of a type and bytes in hex; answers each with what generated C++ says to them. Counts
// the memory that decoding takes, and says so where it is more than it may be.
#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <new>
#include <sstream>
#include <string>

#include "cases.hpp"

namespace {

constexpr std::size_t header = alignof(std::max_align_t);  // holds the size of what follows
constexpr std::size_t allowance = 64 * 1024;

struct Memory {
  std::size_t now = 0;
  std::size_t peak = 0;
  std::size_t while_decoding = 0;
} memory;

}  // namespace

void* operator new(std::size_t size) {
  auto* block = static_cast<char*>(std::malloc(header + size));
  if (block == nullptr) throw std::bad_alloc();
  *reinterpret_cast<std::size_t*>(block) = size;
  memory.now += size;
  memory.peak = std::max(memory.peak, memory.now);
  return block + header;
}
void operator delete(void* given) noexcept {
  if (given == nullptr) return;
  char* block = static_cast<char*>(given) - header;
  memory.now -= *reinterpret_cast<std::size_t*>(block);
  std::free(block);
}
void operator delete(void* given, std::size_t) noexcept { operator delete(given); }

int main() {
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string type, hex;
    words >> type >> hex;
    const gecos::Bytes bytes = from_hex(hex);

    const std::size_t before = memory.now;
    memory.peak = before;
    const Verdict verdict = judge(type, bytes, [] { memory.while_decoding = memory.peak; });
    const std::size_t taken = memory.while_decoding - before;
    const auto known = std::find_if(judged_types().begin(), judged_types().end(),
                                    [&](const JudgedType& each) { return each.name == type; });
    const double most = known->memory_factor * static_cast<double>(bytes.size()) + allowance;
    if (static_cast<double>(taken) > most) {
      std::cout << "greedy " << taken << " bytes allocated, at most " << most << " are allowed\n";
    } else if (verdict.bytes) {
      std::cout << "accepted " << to_hex(*verdict.bytes) << "\n";
    } else {
      std::cout << "refused " << verdict.why << "\n";
    }
  }
}
