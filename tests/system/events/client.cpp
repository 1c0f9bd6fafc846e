// Subscribes to the events of ALARM and prints what it hears: the C++ half of the pairs in
// test_events.py.
#include <cstdio>
#include <cstdlib>

#include "button_client.hpp"
#include "gecos/gecos.hpp"

using namespace std::chrono_literals;

namespace {

/// Waits for the end of `command`, which must succeed.
void demand(const gecos::Command<void>& command) {
  if (const auto ended = command.get(); !ended) {
    std::printf("%s\n", ended.error().text.c_str());
    std::exit(1);
  }
}

}  // namespace

int main(int, char** argv) {
  gecos::Lab lab;
  gecos::CreateOptions over;
  over.medium = gecos::media::kind_from(argv[1]);
  const auto alarm = lab.create<buttons::Alarm>("ALARM", over).value();
  demand(alarm.press("long ago", 1, 2));
  auto pressed = alarm.pressed(gecos::stream).value();
  std::printf("before: %s\n", pressed.latest() ? "an event" : "nothing");
  demand(alarm.press("ann", 2.5, 2));
  for (int i = 0; i < 2; ++i) {
    const auto event = pressed.next(30s).value();
    std::printf("%s with %g N, missed %d\n", event.value.who.c_str(), event.value.force,
                static_cast<int>(event.lost));
  }
  auto lifted = alarm.lifted(gecos::stream).value();
  demand(alarm.lift(40));
  std::uint64_t told = 0;
  while (told < 40) told += 1 + lifted.next(30s).value().lost;
  std::printf("lifted: %d\n", static_cast<int>(told));
  const auto refused = alarm.silenced(gecos::stream);
  std::printf("without a lease: %s\n", std::string(to_string(refused.error().detail)).c_str());
  const auto lease = gecos::actor(alarm);
  auto silenced = alarm.silenced(gecos::stream).value();
  demand(alarm.silence(7));
  std::printf("silenced: %d\n", silenced.next(30s).value().value.zone);
}
