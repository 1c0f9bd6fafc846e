#pragma once

#include <optional>
#include <string>

#include "gecos/access/lab_file.hpp"

namespace gecos::session {

struct LabFilePath {
  std::string path;
  bool must_exist = false;  ///< LabOptions::lab_file or GECOS_LAB_FILE names the file
};
/// Returns the path of the lab file of this program. `option`, the value of LabOptions::lab_file,
/// names the file. If `option` is empty, GECOS_LAB_FILE names the file; if that is not set either,
/// the file is /etc/gecos/lab.toml.
LabFilePath lab_file_path(const std::string& option);

/// Reads the text of the lab file, and sets `must_exist` when the file exists. Returns an empty
/// text if the file does not exist and need not exist. Returns an error if the file cannot be read,
/// is larger than 64 KiB, belongs neither to root nor to the user of this process, or may be
/// written by other users. Returns nullopt while a program seems to be writing the file: the file
/// was changed within the last 100 ms or during the reading, or was emptied within the last second.
/// Blocks while the file system does not answer, so call this function on a FileThread.
std::optional<access::EditedLabFile::Text> lab_file_text(const std::string& path, bool& must_exist);

}  // namespace gecos::session
