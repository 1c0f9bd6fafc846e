// cpp_mistakes <name>: makes one mistake of cpp.toml. cpp_mistakes --serve: serves FAR until it is
// killed.
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

#include "bench.hpp"

namespace {

const gecos::ObjectOptions simulated{
    .simulated = true, .media = {gecos::media::Kind::Inproc, gecos::media::Kind::Shm}};

[[noreturn]] void end(const std::string& why) {
  std::cerr << why << std::endl;
  std::exit(1);
}

void serve(gecos::Server& server, const std::string& name, Turntable& table) {
  if (const auto served = server.add(name, table, simulated); !served) end(served.error().text);
}

int serve_far() {
  gecos::Lab lab;
  Turntable table;
  gecos::Server server(lab);
  serve(server, "FAR", table);
  std::cout << "ready" << std::endl;
  server.run();
  return 0;
}

}  // namespace

FarTable::FarTable() {
  std::array<int, 2> ready{};
  if (::pipe(ready.data()) != 0) end("no pipe");
  process_ = ::fork();
  if (process_ == 0) {
    ::dup2(ready[1], STDOUT_FILENO);
    ::execl("/proc/self/exe", "cpp_mistakes", "--serve", static_cast<char*>(nullptr));
    ::_exit(1);
  }
  ::close(ready[1]);
  char letter = 0;
  if (::read(ready[0], &letter, 1) != 1) end("FAR is not served");
  ::close(ready[0]);
}

void FarTable::kill() {
  if (process_ == 0) return;
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
  process_ = 0;
}

int main(int count, char** words) {
  const std::string name = count == 2 ? words[1] : "";
  if (name == "--serve") return serve_far();
  const auto mistake = mistakes.find(name);
  if (mistake == mistakes.end()) end("usage: cpp_mistakes <name of a mistake>");
  gecos::Lab lab;
  gecos::broker::Broker broker;
  Turntable servant;
  gecos::Server server(lab);
  if (const auto served = broker.serve(server, simulated.media); !served) end(served.error().text);
  serve(server, "TABLE", servant);
  const auto table = lab.create<lab::Table>("TABLE");
  if (!table) end(table.error().to_string());
  Bench bench{lab, server, servant, *table};
  mistake->second(bench);
}
