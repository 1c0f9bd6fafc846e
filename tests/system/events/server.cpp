// Serves ALARM: the C++ half of the pairs in test_events.py.
#include "gecos/gecos.hpp"
#include "ringer.hpp"

int main() {
  gecos::Lab lab;
  ringing::Ringer alarm;
  return gecos::serve(lab, {{"ALARM", alarm, {.simulated = true}}});
}
