#include "gecos/session/client/lab_file_broker.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "gecos/base/mutex.hpp"
#include "gecos/lab.hpp"
#include "gecos/session/process/lab_file_text.hpp"

namespace gecos::session {
namespace {

constexpr Duration pause_between_readings = std::chrono::milliseconds(25);
/// The reading of the lab file is given at least this time, so that even a search for the broker
/// whose deadline has already passed can read the file.
constexpr Duration shortest_reading = std::chrono::milliseconds(100);
/// The wait if there is no deadline.
constexpr Duration longest_reading = std::chrono::hours(1);

tl::unexpected<std::string> unusable(const std::string& why) {
  return tl::unexpected("the lab file, which may name the broker, cannot be used: " + why +
                        "; correct that, or name the broker in GECOS_BROKER");
}

}  // namespace

/// The data that the reading thread uses. It outlives the LabFileBroker if the file system does not
/// answer, because the thread then still waits.
struct LabFileBroker::Shared {
  explicit Shared(const LabFilePath& named) : path(named.path), must_exist(named.must_exist) {}
  void read() {
    bool named = must_exist;
    auto now = lab_file_text(path, named);
    const MutexLock lock(mutex);
    text = std::move(now);
  }

  const std::string path;
  const bool must_exist;
  Mutex mutex;
  /// The text of the file; no value while the file is being written.
  std::optional<access::EditedLabFile::Text> text GECOS_GUARDED_BY(mutex);
};

LabFileBroker::LabFileBroker(const std::string& lab_file)
    : shared_(std::make_shared<Shared>(lab_file_path(lab_file))) {}

LabFileBroker::~LabFileBroker() = default;

tl::expected<access::LabBroker, std::string> LabFileBroker::read(TimePoint deadline) {
  try {
    if (!thread_) {
      thread_ =
          std::make_unique<FileThread>("gecos-lab-file", [shared = shared_] { shared->read(); });
    }
  } catch (const std::system_error& failed) {
    return unusable(nothing_left("a thread that reads " + shared_->path, failed));
  }
  std::optional<access::EditedLabFile::Text> text;
  for (;;) {
    const TimePoint began = SystemClock().now();
    const Duration patience = std::clamp(deadline - began, shortest_reading, longest_reading);
    if (!thread_->await(thread_->ask(), patience)) {
      return unusable(shared_->path + ": its file system does not answer");
    }
    {
      const MutexLock lock(shared_->mutex);
      text = std::exchange(shared_->text, std::nullopt);
    }
    if (text) break;
    if (began + pause_between_readings >= deadline) {
      thread_.reset();
      return unusable(shared_->path + ": another program keeps writing to the file");
    }
    std::this_thread::sleep_for(pause_between_readings);
  }
  thread_.reset();
  const auto broker = text->and_then(
      [&](const std::string& it) { return access::parse_lab_broker(it, shared_->path); });
  if (!broker) return unusable(to_string(broker.error()));
  return *broker;
}

}  // namespace gecos::session
