// Reads lines of a type, "bytes" or "json", and such; answers each with what generated C++ makes of
// it.
#include <algorithm>
#include <iostream>
#include <string>

#include "cases.hpp"
#include "json_judges.hpp"

int main() {
  std::string type, what, given;
  while (std::cin >> type >> what && std::getline(std::cin >> std::ws, given)) {
    const auto judge = std::find_if(json_judges().begin(), json_judges().end(),
                                    [&](const JsonJudge& each) { return each.type == type; });
    if (judge == json_judges().end()) {
      std::cout << "no such type\n";
    } else if (what == "bytes") {
      std::cout << judge->written(from_hex(given == "-" ? "" : given)) << "\n";
    } else {
      std::cout << judge->read(given) << "\n";
    }
  }
}
