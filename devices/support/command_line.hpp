#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/result.hpp"

namespace devices {

/// One option `--word VALUE` of a program.
struct Option {
  std::string word;      ///< name of the option, without the dashes
  std::string standard;  ///< default value
  std::string says;      ///< text for --help, with the unit
};

/// The arguments of a program. `main` must return `exit_status` if it has a value.
class CommandLine {
 public:
  /// Prints the usage for --help. For a bad argument prints the error, then the usage.
  CommandLine(std::string program, std::string purpose, std::vector<Option> options, int count,
              char** words);

  /// 0 after --help, 2 after a bad argument, nullopt if the program should continue.
  std::optional<int> exit_status() const { return exit_status_; }

  const std::string& text(std::string_view word) const;
  /// The value in the option's unit: millimetres, degrees, newtons or none. If the option's default
  /// is a number, the constructor has already refused values that are not finite numbers.
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
