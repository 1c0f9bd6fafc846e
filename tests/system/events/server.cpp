// Serves ALARM: the C++ half of the pairs in test_events.py.
#include "gecos/gecos.hpp"
#include "sender.hpp"

int main() {
  gecos::Lab lab;
  buttons::Sender alarm;
  return gecos::serve(lab, {{"ALARM", alarm, {.simulated = true}}});
}
