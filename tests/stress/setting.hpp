// What the programs of the stress tests are told.
#pragma once

#include <map>
#include <string>

#include "gecos/lab.hpp"

namespace stress {

/// Words of the command line, "name=value" each. A word that is not known ends the program.
class Setting {
 public:
  Setting(int count, char** words, std::map<std::string, std::string> standard);

  const std::string& text(const std::string& name) const { return values_.at(name); }
  double number(const std::string& name) const;
  gecos::media::Kind medium() const;
  /// With faults on lcm when `faults` says so: "loss,duplication,reordering,corruption,seed". The
  /// broker, met over shm, has none.
  gecos::Lab lab() const;

 private:
  std::map<std::string, std::string> values_;
};

}  // namespace stress
