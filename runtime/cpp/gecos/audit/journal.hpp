#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "gecos/base/descriptor.hpp"
#include "gecos/base/result.hpp"

namespace gecos::audit {

/// The files of an audit: `audit.jsonl`, and the older `audit.1.jsonl`, `audit.2.jsonl` and so on.
/// The files belong to the user of the process, and no other user may read them.
///
/// Several processes may append to the same files at once. The functions may block while the disk
/// does not answer.
class Journal {
 public:
  struct Limits {
    std::size_t bytes = std::size_t{16}
                        << 20;  ///< a file of this size is full, and a new one begins
    unsigned files = 4;         ///< the maximum number of files; the oldest one is removed
  };
  /// The folder and its missing parents are created when the first line is appended.
  explicit Journal(std::string folder) : Journal(std::move(folder), Limits()) {}
  Journal(std::string folder, Limits limits);

  /// Appends whole lines. On failure, returns the reason; some of the lines may then be in the
  /// file, the last one incomplete. The next call begins a new line.
  tl::expected<void, std::string> append(std::string_view lines);

 private:
  tl::expected<void, std::string> open();
  tl::expected<void, std::string> write(std::string_view bytes);
  bool current() const;
  /// Begins a new file if the present file is full. Does nothing while another process begins a new
  /// file.
  void rotate();
  std::string path(unsigned age) const;

  const std::string folder_;
  const Limits limits_;
  Descriptor file_;
  bool torn_ = false;  ///< the last line in the file may be incomplete
};

}  // namespace gecos::audit
