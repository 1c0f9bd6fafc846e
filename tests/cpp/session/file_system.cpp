#include "file_system.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdarg>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace {

/// What happens once, when the file with this path is used next.
struct Awaited {
  std::string path;
  std::function<void()> action;
};

struct FileSystem {
  std::mutex mutex;
  std::condition_variable changed;
  std::string hangs;  ///< part of the paths that hang; empty: none
  int hanging = 0;    ///< number of threads that hang
  bool no_threads = false;
  int refused_threads = 0;
  Awaited open;
  Awaited read;
};

FileSystem& files() {
  static FileSystem all;
  return all;
}

std::atomic<bool> in_use{false};          // orders no other memory
std::atomic<int> awaited_descriptor{-1};  // of the file of `read`; orders no other memory

/// Calls the action unless it awaits another file.
void act(Awaited& awaited, const std::string& path) {
  Awaited now;
  {
    const std::lock_guard lock(files().mutex);
    if (awaited.path != path) return;
    now = std::exchange(awaited, {});
  }
  now.action();
}

void hang(const std::string& path) {
  std::unique_lock lock(files().mutex);
  const auto hangs = [&] {
    return !files().hangs.empty() && path.find(files().hangs) != std::string::npos;
  };
  if (!hangs()) return;
  ++files().hanging;
  files().changed.notify_all();
  files().changed.wait(lock, [&] { return !hangs(); });
  --files().hanging;
  files().changed.notify_all();
}

void note_opened(const std::string& path, int descriptor) {
  const std::lock_guard lock(files().mutex);
  if (path == files().read.path) awaited_descriptor = descriptor;
}

std::string awaited_path() {
  const std::lock_guard lock(files().mutex);
  return files().read.path;
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" [[gnu::visibility("default")]] int open(const char* path, int flags, ...) {
  static const auto real = next<int(const char*, int, ...)>("open");
  va_list rest;
  va_start(rest, flags);
  const auto mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : mode_t{0};
  va_end(rest);
  if (in_use) {
    hang(path);
    act(files().open, path);
  }
  const int descriptor = real(path, flags, mode);
  if (in_use) note_opened(path, descriptor);
  return descriptor;
}

extern "C" [[gnu::visibility("default")]] ssize_t read(int descriptor, void* into, size_t size) {
  static const auto real = next<ssize_t(int, void*, size_t)>("read");
  int awaited = descriptor;
  if (descriptor >= 0 && awaited_descriptor.compare_exchange_strong(awaited, -1)) {
    act(files().read, awaited_path());
  }
  return real(descriptor, into, size);
}

extern "C" [[gnu::visibility("default")]] int pthread_create(pthread_t* thread,
                                                             const pthread_attr_t* attributes,
                                                             void* (*run)(void*),
                                                             void* argument) noexcept {
  static const auto real =
      next<int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create");
  {
    const std::lock_guard lock(files().mutex);
    if (files().no_threads) {
      ++files().refused_threads;
      files().changed.notify_all();
      return EAGAIN;
    }
  }
  return real(thread, attributes, run, argument);
}

namespace probe {

HangingFiles::HangingFiles(const std::string& part) {
  in_use = true;
  const std::lock_guard lock(files().mutex);
  files().hangs = part;
}

HangingFiles::~HangingFiles() {
  std::unique_lock lock(files().mutex);
  files().hangs.clear();
  files().changed.notify_all();
  files().changed.wait(lock, [] { return files().hanging == 0; });
}

void HangingFiles::await_reader() {
  std::unique_lock lock(files().mutex);
  if (!files().changed.wait_for(lock, std::chrono::seconds(30),
                                [] { return files().hanging > 0; })) {
    throw std::runtime_error("no thread has opened a file of " + files().hangs);
  }
}

NoThreads::NoThreads() {
  const std::lock_guard lock(files().mutex);
  files().no_threads = true;
  files().refused_threads = 0;
}

NoThreads::~NoThreads() {
  const std::lock_guard lock(files().mutex);
  files().no_threads = false;
}

void NoThreads::await_try() {
  std::unique_lock lock(files().mutex);
  if (!files().changed.wait_for(lock, std::chrono::seconds(30),
                                [] { return files().refused_threads > 0; })) {
    throw std::runtime_error("nobody has started a thread");
  }
}

void at_next_open(const std::string& path, std::function<void()> action) {
  in_use = true;
  const std::lock_guard lock(files().mutex);
  files().open = {path, std::move(action)};
}

void at_next_read(const std::string& path, std::function<void()> action) {
  in_use = true;
  const std::lock_guard lock(files().mutex);
  files().read = {path, std::move(action)};
}

}  // namespace probe
