#include "allocations.hpp"

#include <cstdlib>
#include <new>

namespace {
thread_local int allocations = 0;
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace robcl {

CountAllocations::CountAllocations() : before_(allocations) {}
int CountAllocations::so_far() const { return allocations - before_; }

}  // namespace robcl
