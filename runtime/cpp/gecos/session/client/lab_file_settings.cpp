#include "gecos/session/client/lab_file_settings.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "gecos/base/file_thread.hpp"
#include "gecos/lab.hpp"
#include "gecos/media/kinds.hpp"
#include "gecos/session/process/lab_file_text.hpp"

namespace gecos::session {
namespace {

constexpr Duration pause_between_readings = std::chrono::milliseconds(25);
/// The reading of the lab file is given at least this time, so that even a search for the broker
/// whose deadline has already passed can read the file.
constexpr Duration shortest_reading = std::chrono::milliseconds(100);
/// The wait if there is no deadline.
constexpr Duration longest_reading = std::chrono::hours(1);

std::string unusable(const std::string& which, const std::string& why) {
  return "the lab file, which may " + which + ", cannot be used: " + why + "; correct that";
}

}  // namespace

struct LabFileSettings::Reading {
  /// The data that the reading thread uses. They outlive the LabFileSettings if the file system
  /// does not answer, because the thread then still waits.
  struct File {
    File(std::string its_path, bool named) : path(std::move(its_path)), must_exist(named) {}
    void read() {
      bool exists = must_exist;
      auto now = lab_file_text(path, exists);
      const MutexLock lock(mutex);
      text = std::move(now);
    }

    const std::string path;
    const bool must_exist;
    Mutex mutex;
    /// The text of the file; no value while the file is being written.
    std::optional<access::EditedLabFile::Text> text GECOS_GUARDED_BY(mutex);
  };

  Reading(const std::string& path, bool must_exist)
      : file(std::make_shared<File>(path, must_exist)),
        thread("gecos-lab-file", [shared = file] { shared->read(); }) {}

  const std::shared_ptr<File> file;
  FileThread thread;
};

LabFileSettings::LabFileSettings(const std::string& lab_file)
    : path_(lab_file_path(lab_file).path), must_exist_(lab_file_path(lab_file).must_exist) {}

LabFileSettings::~LabFileSettings() = default;

std::shared_ptr<LabFileSettings::Reading> LabFileSettings::present_reading() {
  const MutexLock lock(mutex_);
  if (!reading_) reading_ = std::make_shared<Reading>(path_, must_exist_);
  return reading_;
}

void LabFileSettings::end(const std::shared_ptr<Reading>& done) {
  const MutexLock lock(mutex_);
  // The caller still has `done`, so its thread is not joined while the mutex is held.
  if (reading_ == done) reading_.reset();
}

tl::expected<std::string, std::string> LabFileSettings::text(TimePoint deadline) {
  std::shared_ptr<Reading> reading;
  try {
    reading = present_reading();
  } catch (const std::system_error& failed) {
    return tl::unexpected(nothing_left("a thread that reads " + path_, failed));
  }
  std::optional<access::EditedLabFile::Text> text;
  for (;;) {
    const TimePoint began = SystemClock().now();
    const Duration patience = std::clamp(deadline - began, shortest_reading, longest_reading);
    if (!reading->thread.await(reading->thread.ask(), patience)) {
      return tl::unexpected(path_ + ": its file system does not answer");
    }
    {
      const MutexLock lock(reading->file->mutex);
      text = reading->file->text;
    }
    if (text) break;
    if (began + pause_between_readings >= deadline) {
      end(reading);
      return tl::unexpected(path_ + ": another program keeps writing to the file");
    }
    std::this_thread::sleep_for(pause_between_readings);
  }
  end(reading);
  return std::move(*text).map_error(
      [](const access::LabFileError& error) { return to_string(error); });
}

tl::expected<access::LabBroker, std::string> LabFileSettings::broker(TimePoint deadline) {
  return text(deadline)
      .and_then([&](const std::string& it) {
        return access::parse_lab_broker(it, path_).map_error(
            [](const access::LabFileError& error) { return to_string(error); });
      })
      .map_error([](const std::string& why) {
        return unusable("name the broker", why) + ", or name the broker in GECOS_BROKER";
      });
}

StatedMedia LabFileSettings::media(TimePoint deadline) {
  return text(deadline)
      .and_then([&](const std::string& it) {
        return access::parse_lab_media(it, path_, media::all_names())
            .map_error([](const access::LabFileError& error) { return to_string(error); });
      })
      .map_error([](const std::string& why) {
        return unusable("say that a medium is not real-time", why);
      });
}

}  // namespace gecos::session
