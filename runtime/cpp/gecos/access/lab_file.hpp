#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "gecos/access/access_policy.hpp"
#include "gecos/base/result.hpp"

namespace gecos::access {

/// An error in a lab file. Its text is, for example, "lab.toml:3: allow.user: this key is unknown;
/// …".
struct LabFileError {
  std::string file;
  std::size_t line = 0;  ///< counted from 1; 0: the error concerns the whole file
  std::string key;       ///< for example "objects.RX90.allow.users"; may be empty
  std::string text;      ///< what is wrong, and what to write instead
};
std::string to_string(const LabFileError& error);

/// The names of all media, which a lab file may use in [media.NAME].
using MediaNames = std::span<const std::string_view>;

/// Reads the text of a lab file, the `lab.toml` of a laboratory. Returns the rules in the tables
/// [admin], [allow], [names], [objects.NAME] and [streams]. Checks [broker] as `parse_lab_broker`
/// does, and [media.NAME] as `parse_lab_media` does. In the tables that only `gecos up` reads
/// ([clock] and [programs.NAME]), checks that each key is known. Error messages contain `file`, the
/// path of the file.
tl::expected<LabAccess, LabFileError> parse_lab_file(const std::string& text,
                                                     const std::string& file, MediaNames media);

/// The address of a laboratory's broker, as the table [broker] of a lab file states it.
struct LabBroker {
  std::string address{};  ///< for example "lcm"; empty: the broker is on the host of the program
  /// Where the address is written, for messages: "[broker] in /etc/gecos/lab.toml:4".
  std::string place{};
};

/// Returns what the text of a lab file says about the broker. Fails if [broker] has an error, if a
/// table is unknown, which may be a misspelt [broker], and if the text is not TOML. Errors within
/// other tables do not matter here: a mistake in a list of users must not keep programs from the
/// broker.
tl::expected<LabBroker, LabFileError> parse_lab_broker(const std::string& text,
                                                       const std::string& file);

/// What a table [media.NAME] of a lab file states about its medium.
struct LabMedium {
  bool real_time = false;  ///< whether the medium is real-time in this laboratory
  /// Where this is written, for messages: "[media.lcm] in /etc/gecos/lab.toml:2".
  std::string place{};
};

/// What a lab file states about media, by the name of the medium. A medium without an entry keeps
/// its own promise.
using LabMedia = std::map<std::string, LabMedium, std::less<>>;

/// Returns what the text of a lab file states about the media. Fails if a table [media.NAME] has an
/// error, if NAME is not in `media`, if another table is unknown, which may be a misspelt [media],
/// and if the text is not TOML. As for `parse_lab_broker`, errors within other tables do not
/// matter.
tl::expected<LabMedia, LabFileError> parse_lab_media(const std::string& text,
                                                     const std::string& file, MediaNames media);

/// The access lists of a lab file that is edited while a server runs. While the edited text has an
/// error, the lists of the last valid text stay in force.
class EditedLabFile {
 public:
  using Text = tl::expected<std::string, LabFileError>;

  /// @param file the path of the lab file, for error messages
  /// @param media the names of all media; they must outlive this object
  EditedLabFile(std::string file, MediaNames media);

  /// Takes the present text of the file, or the error that occurred when the file was read. Returns
  /// the error that the caller must report. Returns nullopt when `now` is valid, and when `now`
  /// equals the `now` of the previous call, so that each error is reported once.
  std::optional<LabFileError> take(const Text& now);

  const LabAccess& lists() const { return lists_; }
  /// Returns whether take() has ever got a valid text.
  bool known() const { return known_; }
  /// Returns the error in what the last call of take() got; nullopt if that was a valid text.
  const std::optional<LabFileError>& error() const { return error_; }

 private:
  /// What take() got last: the text of the file, or the error as a text.
  std::optional<std::string> taken_{};
  bool readable_ = false;  ///< whether `taken_` is the text of the file
  bool known_ = false;
  std::optional<LabFileError> error_{};
  LabAccess lists_;
  MediaNames media_;
};

}  // namespace gecos::access
