// Reads lines of a type and bytes in hex; answers each with what generated C++ says to them.
#include <iostream>
#include <sstream>
#include <string>

#include "cases.hpp"

int main() {
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string type, hex;
    words >> type >> hex;
    const Verdict verdict = judge(type, from_hex(hex));
    if (verdict.bytes) {
      std::cout << "accepted " << to_hex(*verdict.bytes) << "\n";
    } else {
      std::cout << "refused " << verdict.why << "\n";
    }
  }
}
