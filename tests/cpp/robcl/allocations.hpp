// Proof that a real-time path allocates nothing. Replaces operator new of the test program.
#pragma once

namespace robcl {

/// Counts what the thread that made it allocates from then on.
class CountAllocations {
 public:
  CountAllocations();
  int so_far() const;

 private:
  int before_;
};

}  // namespace robcl
