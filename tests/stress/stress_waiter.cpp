// Waits without time-out for a command that never ends by itself; when its server is gone, again.
// SIGTERM: ends once the command has ended that it waits for.

#include <atomic>
#include <csignal>
#include <cstdio>

#include "another_try.hpp"
#include "gecos/gecos.hpp"
#include "record.hpp"
#include "setting.hpp"
#include "stress/workbench_client.hpp"

namespace {

using namespace std::chrono_literals;

std::atomic<bool> told_to_end{false};

/// One session: false when there is no server.
bool wait_once(gecos::Lab& lab, const stress::Setting& setting, const stress::Record& record,
               std::uint64_t turn) {
  const auto bench =
      lab.create<stress::Workbench>("BENCH", {.medium = setting.medium(), .patience = 500ms});
  if (!bench) return false;
  const auto about = gecos::describe(*bench).get();
  if (!about) return false;
  const std::string session = std::to_string(turn);
  record.note("open " + session + " " + std::to_string(about->pid));
  const auto lease = gecos::actor(*bench, "stress");
  if (lease) record.note("granted " + session + " ACTOR");
  const std::uint64_t number = (static_cast<std::uint64_t>(setting.number("number")) << 32) + turn;
  const std::string name = std::to_string(number);
  record.note("issue " + name + " file " + session + " " +
              std::to_string(stress::answer(number, 0)));
  const auto command = bench->file(number, 0, 1e6);
  const gecos::State state = command.wait();
  record.note("end " + name + " " + std::string(to_string(state)) + " " +
              std::string(to_string(command.progress().detail)) + " -");
  return true;
}

}  // namespace

int main(int count, char** words) {
  const stress::Setting setting(count, words,
                                {{"number", "1"},
                                 {"record", ""},
                                 {"medium", "shm"},
                                 {"faults", ""},
                                 {"rest_ms", "10"},
                                 {"pretends", ""},
                                 {"change", ""},
                                 {"seed", "1"}});
  std::signal(SIGTERM, [](int) { told_to_end = true; });
  const stress::Record record(setting.text("record"));
  const stress::Balance balance;
  std::puts("ready");
  std::fflush(stdout);
  {
    gecos::Lab lab(setting.lab());
    for (std::uint64_t turn = 1; !told_to_end; ++turn) {
      if (!wait_once(lab, setting, record, turn)) stress::rest_before_another_try();
    }
  }
  record.note("done");
  balance.close();
}
