#include "devices/support/command_line.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "devices/support/lab_clock.hpp"

namespace devices {
namespace {

std::optional<double> as_number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  constexpr double most = 1e9;  // more is a slip, and not every integer type holds it
  if (text.empty() || *end != '\0' || !(std::abs(value) <= most)) return std::nullopt;
  return value;
}

Option clock_option() {
  const char* const of_laboratory = std::getenv("ROBCL_CLOCK");
  const bool set = of_laboratory != nullptr && *of_laboratory != '\0';
  return {"clock", set ? of_laboratory : "1",
          "simulated seconds per second of real time; default: ROBCL_CLOCK, if set"};
}

}  // namespace

CommandLine::CommandLine(std::string program, std::string purpose, std::vector<Option> options,
                         int count, char** words, std::string operand)
    : program_(std::move(program)),
      purpose_(std::move(purpose)),
      operand_(std::move(operand)),
      options_(std::move(options)) {
  options_.push_back(clock_option());
  for (const Option& option : options_) values_[option.word] = option.standard;
  read(count, words);
  if (!exit_status_) check_clock();
}

void CommandLine::check_clock() {
  const auto speed = as_number(text("clock"));
  if (speed && *speed >= LabClock::slowest && *speed <= LabClock::fastest) return;
  char wanted[80];
  std::snprintf(wanted, sizeof wanted, " needs a number from %g to %g", LabClock::slowest,
                LabClock::fastest);
  refuse(name_of_clock() + wanted + ", not '" + text("clock") + "'");
}

std::string CommandLine::name_of_clock() const {
  return clock_given_ ? "'--clock'" : "ROBCL_CLOCK";
}

void CommandLine::need_real_time(const std::string& why) {
  if (clock() == 1) return;
  refuse(name_of_clock() + " is " + text("clock") + ", but " + why +
         "; only simulated devices have another clock than 1");
}

void CommandLine::read(int count, char** words) {
  for (int at = 1; at < count; ++at) {
    const std::string word = words[at];
    if (word == "--help" || word == "-h") {
      std::fputs(usage().c_str(), stdout);
      exit_status_ = 0;
      return;
    }
    if (word == "--insecure") {
      admission_ = gecos::Admission::Insecure;
      continue;
    }
    const auto option = std::find_if(options_.begin(), options_.end(), [&](const Option& known) {
      return word == "--" + known.word;
    });
    if (option == options_.end()) return refuse("'" + word + "' is not an option of this program");
    if (++at == count) return refuse("'" + word + "' needs a value");
    if (as_number(option->standard) && !as_number(words[at])) {
      return refuse("'" + word + "' needs a number, not '" + words[at] + "'");
    }
    values_[option->word] = words[at];
    clock_given_ = clock_given_ || option == options_.end() - 1;
  }
}

void CommandLine::refuse(const std::string& what) {
  std::fprintf(stderr, "%s: %s\n%s", program_.c_str(), what.c_str(), usage().c_str());
  exit_status_ = 2;
}

std::string CommandLine::usage() const {
  std::string text = "usage: " + program_ + (operand_.empty() ? "" : " " + operand_) +
                     " [--WORD VALUE]... [--insecure]\n" + purpose_ + "\n";
  for (const Option& option : options_) {
    std::string left = "  --" + option.word;
    left.resize(std::max<std::size_t>(left.size() + 1, 22), ' ');
    text +=
        left + option.says + " (" + (option.standard.empty() ? "none" : option.standard) + ")\n";
  }
  text += "  --insecure          admit every user of every host; for simulated devices only\n";
  return text + "Prints one line when it is ready and ends on SIGINT or SIGTERM.\n";
}

const std::string& CommandLine::text(std::string_view word) const {
  return values_.find(word)->second;
}

double CommandLine::number(std::string_view word) const {
  return as_number(text(word)).value_or(0.0);
}

}  // namespace devices
