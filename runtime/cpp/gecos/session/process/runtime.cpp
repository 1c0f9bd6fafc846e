#include "gecos/session/process/runtime.hpp"

#include <pthread.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <memory>
#include <system_error>

#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/per_process.hpp"
#include "gecos/base/user_and_host.hpp"
#include "gecos/media/kinds.hpp"

namespace gecos::session {
namespace {

/// The runtimes of this process. Their sessions are closed in order when the process exits.
class OpenRuntimes {
 public:
  /// Returns the list of the runtimes of this process. A forked child gets a new list, because the
  /// threads of the parent's runtimes do not exist in the child.
  static OpenRuntimes& instance();

  void add(const std::shared_ptr<Runtime>& runtime) {
    const MutexLock lock(mutex_);
    std::erase_if(runtimes_, [](const auto& known) { return known.expired(); });
    runtimes_.push_back(runtime);
  }

 private:
  struct CloseAtExit {
    ~CloseAtExit() {
      for (const auto& runtime : instance().alive()) {
        runtime->close_sessions(std::chrono::seconds(1));
      }
    }
  };

  std::vector<std::shared_ptr<Runtime>> alive() {
    const MutexLock lock(mutex_);
    std::vector<std::shared_ptr<Runtime>> found;
    for (const auto& known : runtimes_) {
      if (auto runtime = known.lock()) found.push_back(std::move(runtime));
    }
    return found;
  }

  Mutex mutex_;
  std::vector<std::weak_ptr<Runtime>> runtimes_ GECOS_GUARDED_BY(mutex_);
};

OpenRuntimes& OpenRuntimes::instance() {
  static constinit PerProcess<OpenRuntimes> runtimes;
  static const CloseAtExit at_exit;
  return runtimes.get();
}

std::atomic<std::uint64_t> incarnation_of_this_process{
    0};  // 0: no number was drawn yet; orders no other memory

std::uint64_t random_incarnation() {
  std::uint64_t number = 0;
  while (number == 0) {
    if (::getrandom(&number, sizeof number, 0) != sizeof number) number = 0;
  }
  return number;
}

}  // namespace

std::string nothing_left(std::string_view what_for, const std::system_error& why) {
  return "this process has no resources left for " + std::string(what_for) + ": " + why.what();
}

IncarnationId process_incarnation() {
  [[maybe_unused]] static const int registered =
      ::pthread_atfork(nullptr, nullptr, [] { incarnation_of_this_process.store(0); });
  std::uint64_t known = incarnation_of_this_process.load();
  if (known == 0) {
    const std::uint64_t drawn = random_incarnation();
    if (incarnation_of_this_process.compare_exchange_strong(known, drawn)) known = drawn;
  }
  return IncarnationId{known};
}

Runtime::Runtime(LabOptions options, const Clock& clock, media::WrapMedium wrap)
    : options_(std::move(options)), clock_(clock), wrap_(std::move(wrap)), maintenance_(clock) {}

Runtime::~Runtime() = default;

TimePoint Runtime::heartbeat_anchor() {
  constexpr std::size_t anchors = 10;
  const std::size_t before = sessions_in_packets_.fetch_add(1, std::memory_order_relaxed);
  const auto number = static_cast<int>(before / heartbeats_in_step % anchors);
  return made_ - options_.heartbeat + number * options_.heartbeat / static_cast<int>(anchors);
}

tl::expected<std::shared_ptr<Runtime>, NoLab> Runtime::make(LabOptions options, const Clock& clock,
                                                            media::WrapMedium wrap) {
  // instance() is called before the first Lab is constructed. Therefore, when the program exits,
  // the sessions are closed after a static Lab is destroyed.
  OpenRuntimes& open = OpenRuntimes::instance();
  try {
    auto runtime = std::make_shared<Runtime>(std::move(options), clock, std::move(wrap));
    open.add(runtime);
    return runtime;
  } catch (const std::system_error& failed) {
    return tl::unexpected(NoLab{nothing_left("a Lab", failed), failed});
  }
}

tl::expected<media::Medium*, media::MediumError> Runtime::medium(media::Kind kind) {
  const MutexLock lock(mutex_);
  auto found = media_.find(kind);
  if (found == media_.end()) {
    auto opened = media::open(kind, wrap_);
    log_debug("media",
              opened ? std::string(media::to_string(kind)) + " was opened" : opened.error().text);
    if (!opened) return tl::unexpected(std::move(opened.error()));
    found = media_.emplace(kind, std::move(*opened)).first;
  }
  return found->second.get();
}

const std::string& Runtime::host_identity() {
  const MutexLock lock(mutex_);
  if (!host_identity_) host_identity_ = media::host_identity();
  return *host_identity_;
}

Hello Runtime::introduce(const InterfaceDescription& wanted) const {
  Hello hello;
  hello.user = user_name(getuid());
  hello.host = host_name();
  hello.program = options_.program.empty() ? program_invocation_short_name : options_.program;
  hello.pid = getpid();
  hello.incarnation = number(process_incarnation());
  hello.interface_name = wanted.name;
  hello.interface_hash = wanted.hash;
  // A client gives the server up after `grace`, so the server must refuse older calls. A quarter of
  // `grace` is reserved for the difference between the clocks of two hosts.
  hello.accept_within = options_.grace * 3 / 4;
  return hello;
}

void Runtime::close_at_exit(const std::shared_ptr<Closable>& session) {
  const MutexLock lock(mutex_);
  std::erase_if(sessions_, [](const auto& known) { return known.expired(); });
  sessions_.push_back(session);
}

void Runtime::close_all(const std::vector<std::shared_ptr<Closable>>& sessions,
                        Duration patience) const {
  const TimePoint give_up = deadline_after(patience);
  for (const auto& session : sessions) {
    const Duration left = give_up - std::chrono::steady_clock::now();
    session->close(std::max(left, 2 * options_.heartbeat));
  }
}

void Runtime::close_sessions(Duration patience) {
  std::vector<std::shared_ptr<Closable>> open;
  {
    const MutexLock lock(mutex_);
    for (const auto& known : sessions_) {
      if (auto session = known.lock()) open.push_back(std::move(session));
    }
  }
  close_all(open, patience);
}

}  // namespace gecos::session
