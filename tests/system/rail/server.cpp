// Serves RAIL, or the rails that are named: the C++ half of the pairs in test_pairs.py.

#include <cstdio>
#include <deque>
#include <string>
#include <vector>

#include "gecos/gecos.hpp"
#include "rail.hpp"

int main(int count, char** arguments) {
  std::vector<std::string> names(arguments + 1, arguments + count);
  if (names.empty()) names.emplace_back("RAIL");
  gecos::Lab lab;
  std::deque<Rail> rails;
  gecos::Server server(lab);  // ends before what it serves
  std::string served;
  for (const std::string& name : names) {
    const auto added =
        server.add(name, rails.emplace_back(), {.simulated = true, .thread_safe = true});
    if (!added) {
      std::fprintf(stderr, "%s\n", added.error().text.c_str());
      return 1;
    }
    served += (served.empty() ? "serving " : ", ") + name;
  }
  std::puts(served.c_str());
  std::fflush(stdout);
  server.run();
}
