#include "allocations.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

namespace {

thread_local int allocations = 0;

/// Null: there is no memory left. Not inlined: g++ would see malloc and delete, and take them for a
/// mismatch.
[[gnu::noinline]] void* counted(std::size_t size) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}

[[gnu::noinline]] void* counted(std::size_t size, std::align_val_t alignment) noexcept {
  ++allocations;
  const auto unit = static_cast<std::size_t>(alignment);
  return std::aligned_alloc(unit, size == 0 ? unit : (size + unit - 1) / unit * unit);
}

[[gnu::noinline]] void release(void* memory) noexcept { std::free(memory); }

void* or_throw(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// The whole family: a sanitizer brings operators of its own, and one that is not replaced would not
// be counted, and its memory would come here to be freed.

void* operator new(std::size_t size) { return or_throw(counted(size)); }
void* operator new[](std::size_t size) { return or_throw(counted(size)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new(std::size_t size, std::align_val_t at) { return or_throw(counted(size, at)); }
void* operator new[](std::size_t size, std::align_val_t at) { return or_throw(counted(size, at)); }
void* operator new(std::size_t size, std::align_val_t at, const std::nothrow_t&) noexcept {
  return counted(size, at);
}
void* operator new[](std::size_t size, std::align_val_t at, const std::nothrow_t&) noexcept {
  return counted(size, at);
}

void operator delete(void* memory) noexcept { release(memory); }
void operator delete[](void* memory) noexcept { release(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { release(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  release(memory);
}
void operator delete[](void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  release(memory);
}

namespace robcl {

CountAllocations::CountAllocations() : before_(allocations) {}
int CountAllocations::so_far() const { return allocations - before_; }

namespace {

struct alignas(128) Wide {
  std::byte bytes[256];
};

/// In every program that counts: its zero is that of a counter which counts.
TEST(CountAllocations, CountsEveryFormOfNew) {
  // The functions, and not expressions: a compiler may leave out an unused pair of those.
  const auto at = std::align_val_t{alignof(Wide)};
  const CountAllocations count;
  ::operator delete (::operator new(8), std::size_t{8});
  EXPECT_EQ(count.so_far(), 1);
  ::operator delete[](::operator new[](8));
  EXPECT_EQ(count.so_far(), 2);
  ::operator delete(::operator new(8, std::nothrow), std::nothrow);
  EXPECT_EQ(count.so_far(), 3);
  ::operator delete[](::operator new[](8, std::nothrow), std::nothrow);
  EXPECT_EQ(count.so_far(), 4);
  ::operator delete(::operator new(sizeof(Wide), at), at);
  EXPECT_EQ(count.so_far(), 5);
  ::operator delete[](::operator new[](sizeof(Wide), at), at);
  EXPECT_EQ(count.so_far(), 6);
  ::operator delete(::operator new(sizeof(Wide), at, std::nothrow), at, std::nothrow);
  EXPECT_EQ(count.so_far(), 7);
  ::operator delete[](::operator new[](sizeof(Wide), at, std::nothrow), at, std::nothrow);
  EXPECT_EQ(count.so_far(), 8);
}

TEST(CountAllocations, CountsWhatTheStandardLibraryAllocates) {
  const CountAllocations count;
  const std::vector<Wide> wide(3);
  EXPECT_EQ(count.so_far(), 1);
  const std::string text(1000, 'x');
  EXPECT_EQ(count.so_far(), 2);
}

}  // namespace
}  // namespace robcl
