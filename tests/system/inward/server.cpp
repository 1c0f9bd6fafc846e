// Serves DANCER: the C++ half of the pairs in test_inward.py.
#include "follower.hpp"

int main() {
  gecos::Lab lab;
  feeding::PlainFollower dancer;
  return gecos::serve(lab, {{"DANCER", dancer, {.simulated = true}}});
}
