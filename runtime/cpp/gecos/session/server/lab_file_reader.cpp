#include "gecos/session/server/lab_file_reader.hpp"

#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/kinds.hpp"
#include "gecos/session/process/lab_file_text.hpp"

namespace gecos::session {
namespace {

using access::EditedLabFile;

}  // namespace

/// The data that the thread of a LabFileReader uses. It outlives the LabFileReader if the file
/// system does not answer.
struct LabFileReader::Shared {
  explicit Shared(const LabFilePath& named)
      : must_exist(named.must_exist), file(named.path, media::all_names()) {}
  void read();

  // Used by the thread only.
  bool must_exist;  ///< a setting names the file, or the file existed before
  EditedLabFile file;

  Mutex mutex;
  Found found GECOS_GUARDED_BY(mutex){std::make_shared<const access::LabAccess>(file.lists())};
};

void LabFileReader::Shared::read() {
  const auto text = lab_file_text(file.lists().file, must_exist);
  const auto new_error = text ? file.take(*text) : std::nullopt;
  if (new_error && file.known()) {
    log_error("session", to_string(*new_error) +
                             "; the last lists without an error stay in force; correct the file, "
                             "or write an empty one, which removes all its lists");
  }
  Found now{std::make_shared<const access::LabAccess>(file.lists()), file.known(), file.error(),
            !text.has_value()};
  const MutexLock lock(mutex);
  std::swap(found, now);
}

LabFileReader::LabFileReader(const std::string& lab_file)
    : shared_(std::make_shared<Shared>(lab_file_path(lab_file))),
      path_(shared_->file.lists().file),
      thread_("gecos-lab-file", [shared = shared_] { shared->read(); }) {}

std::shared_ptr<const access::LabAccess> LabFileReader::lists() const {
  const MutexLock lock(shared_->mutex);
  return shared_->found.lists;
}

LabFileReader::Found LabFileReader::found() const {
  const MutexLock lock(shared_->mutex);
  return shared_->found;
}

}  // namespace gecos::session
