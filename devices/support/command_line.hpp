#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/result.hpp"

namespace devices {

/// One `--word VALUE` that a program takes.
struct Option {
  std::string word;      ///< without the dashes
  std::string standard;  ///< used when it is not given
  std::string says;      ///< for --help, with its unit
};

/// The words a program was started with. `main` ends with `exit_status` when there is one.
class CommandLine {
 public:
  /// Prints the usage for --help, and what is wrong with a bad word before the usage.
  CommandLine(std::string program, std::string purpose, std::vector<Option> options, int count,
              char** words);

  /// 0 after --help, 2 after a bad word, nothing when the program shall go on.
  std::optional<int> exit_status() const { return exit_status_; }

  const std::string& text(std::string_view word) const;
  /// Millimetres, degrees, newtons or a plain number, as the option says. A value that is no finite
  /// number was refused already if the option's standard is a number.
  double number(std::string_view word) const;

 private:
  void read(int count, char** words);
  std::string usage() const;
  void refuse(const std::string& what);

  std::string program_, purpose_;
  std::vector<Option> options_;
  std::map<std::string, std::string, std::less<>> values_;
  std::optional<int> exit_status_;
};

}  // namespace devices
