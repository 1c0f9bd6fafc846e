#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/server.hpp"

namespace devices {

/// An option `--WORD VALUE` of a program.
struct Option {
  std::string word;      ///< name of the option, without the dashes
  std::string standard;  ///< default value
  std::string says;      ///< text for --help, with the unit
};

/// Reads the arguments of a device program. Every device program has the flag --insecure, and the
/// option --clock for the speed of its LabClock. The default of --clock is the environment variable
/// ROBCL_CLOCK, which all programs of a laboratory share; without this variable, the default is 1.
/// If `exit_status` has a value, `main` must return this value.
class CommandLine {
 public:
  /// Reads the arguments. Prints the usage if one of them is --help. Prints an error and the usage
  /// if an argument is bad. If the program has an argument before the options, `operand` is the
  /// name of this argument in the usage, and the caller must have removed the argument from
  /// `words`. Otherwise, `operand` is empty.
  CommandLine(std::string program, std::string purpose, std::vector<Option> options, int count,
              char** words, std::string operand = "");

  /// Returns 0 after --help, 2 after a bad argument, and nullopt if the program should continue.
  std::optional<int> exit_status() const { return exit_status_; }

  const std::string& text(std::string_view word) const;
  /// Returns the value of the option `word` as a number, in the unit that the help text of the
  /// option states. @pre the default value of the option is a number; the constructor then refuses
  /// values that are not numbers from -1e9 to 1e9.
  double number(std::string_view word) const;

  /// Returns the value of --clock: simulated seconds that are to pass in a second.
  double clock() const { return number("clock"); }

  /// Returns whether --insecure was given: every user of every host may connect.
  gecos::Admission admission() const { return admission_; }

  /// Refuses a clock other than 1. `why` names the hardware that is not simulated.
  void need_real_time(const std::string& why);

  /// Prints the error `what` and the usage. `exit_status` is 2 from then on.
  void refuse(const std::string& what);

 private:
  void read(int count, char** words);
  void check_clock();
  std::string name_of_clock() const;
  std::string usage() const;

  std::string program_, purpose_, operand_;
  std::vector<Option> options_;
  std::map<std::string, std::string, std::less<>> values_;
  bool clock_given_ = false;
  gecos::Admission admission_ = gecos::Admission::Listed;
  std::optional<int> exit_status_;
};

}  // namespace devices
