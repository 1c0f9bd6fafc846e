#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "gecos/access/access_policy.hpp"
#include "gecos/base/result.hpp"

namespace gecos::access {

/// An error in a lab file. Printed as "lab.toml:3: allow.user: this key is unknown; …".
struct LabFileError {
  std::string file;
  std::size_t line = 0;  ///< counted from 1; 0: the error concerns the whole file
  std::string key;       ///< for example "objects.RX90.allow.users"; may be empty
  std::string text;      ///< what is wrong, and what to write instead
};
std::string to_string(const LabFileError& error);

/// Reads the text of a lab file, the `lab.toml` of a laboratory. Takes the tables [admin], [allow],
/// [names] and [objects.NAME.allow]. Of the tables that `gecos up` reads, [broker] and
/// [programs.NAME], checks that each key is known. `file` is the path for messages.
tl::expected<LabAccess, LabFileError> parse_lab_file(const std::string& text,
                                                     const std::string& file);

/// The access lists of a lab file that is edited while a server runs. An edit with an error leaves
/// the lists of the last text without an error in force.
class EditedLabFile {
 public:
  using Text = tl::expected<std::string, LabFileError>;

  /// @param file the path for messages
  explicit EditedLabFile(std::string file);

  /// Takes the text of the file as it is now, or why the file cannot be read. Returns an error that
  /// must be reported: the same error is returned once, until another text was taken.
  std::optional<LabFileError> take(const Text& now);

  const LabAccess& lists() const { return lists_; }
  /// Returns whether a text without an error was taken.
  bool known() const { return known_; }
  /// Returns the error of the last text; nullopt if it had none.
  const std::optional<LabFileError>& error() const { return error_; }

 private:
  std::optional<std::string> taken_{};  ///< the last text, or the error as a text
  bool readable_ = false;               ///< whether `taken_` is a text
  bool known_ = false;
  std::optional<LabFileError> error_{};
  LabAccess lists_;
};

}  // namespace gecos::access
