#include "gecos/media/shm/acceptor.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/process_barrier.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/media/shm/connection.hpp"
#include "gecos/media/shm/memory.hpp"
#include "gecos/media/shm/stream.hpp"

namespace gecos::media::shm {
namespace {

constexpr std::size_t most_pending = 64;  // above this, the oldest client without Hello is dropped
constexpr int most_at_once = 64;
constexpr std::size_t longest_name = 32;
constexpr std::string_view no_descriptors =
    "the server has no file descriptors left (see `ulimit -n`)";

bool none_left(int error) { return error == EMFILE || error == ENFILE; }

tl::unexpected<MediumError> listen_error(const std::string& text) {
  return tl::unexpected(MediumError{"shm: " + text});
}

std::string file_name(std::string_view name) {
  std::string safe(name.substr(0, longest_name));
  for (char& c : safe) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_') c = '_';
  }
  return safe;
}

bool address_of(const std::string& path, sockaddr_un& into) {
  into = {};
  into.sun_family = AF_UNIX;
  if (path.size() >= sizeof into.sun_path) return false;
  std::copy(path.begin(), path.end(), into.sun_path);
  return true;
}

Descriptor new_socket() {
  return Descriptor(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

bool is_socket(const std::string& path) {
  struct stat found {};
  return ::lstat(path.c_str(), &found) == 0 && S_ISSOCK(found.st_mode);
}

/// Returns whether `path` is a socket at which no process listens. @pre the caller holds the lock
/// of the directory.
bool server_is_dead(const std::string& path) {
  return is_socket(path) && !connect_to(path) && errno == ECONNREFUSED;
}

/// Returns an error text for a `path` that exists already. The text says why no server can listen
/// there, and what the user can do.
std::string occupied(const std::string& path) {
  const std::string elsewhere = "name a directory of your own in GECOS_RUNTIME_DIR";
  const Descriptor their = connect_to(path);
  if (!their && errno == EACCES) {
    return path + " belongs to another user; " + elsewhere;
  }
  if (!their && errno != EAGAIN) {  // EAGAIN: a server listens, and its backlog is full
    const std::string why = system_text(errno);
    if (!is_socket(path)) {
      return path + " exists, but is not the socket of a server; remove it, or " + elsewhere;
    }
    return "cannot find the server of " + path + ": " + why;
  }
  const auto server = their ? peer_of(their.get()) : tl::unexpected(std::string());
  if (!server) {
    return path + " is served already by another program (`fuser -v " + path +
           "` shows which one); use that program, or " + elsewhere;
  }
  const std::string taken = path + " is served already by ";
  if (*server->pid == ::getpid()) return taken + "this program";
  if (server->uid != ::geteuid()) {
    return taken + server->description + ", a program of another user; " + elsewhere;
  }
  const std::string pid = std::to_string(*server->pid);
  return taken + server->description + "; use that one, end it first (kill " + pid +
         "; if it is suspended, kill -CONT " + pid + " resumes it), or " + elsewhere;
}

/// Removes the sockets that killed servers have left behind. The name of such a socket has the form
/// "<name>.<pid>.<number>.sock". @pre the caller holds the lock of the directory.
void sweep(const std::string& directory) {
  DIR* const opened = ::opendir(directory.c_str());
  if (opened == nullptr) return;
  while (const dirent* entry = ::readdir(opened)) {
    const std::string name = entry->d_name;
    if (!name.ends_with(".sock")) continue;
    const std::size_t dot = name.find('.');
    const auto pid = static_cast<pid_t>(std::atol(name.c_str() + dot + 1));
    // The sockets of living processes are skipped, because server_is_dead connects to a socket: a
    // living server would get a connection without a Hello message.
    if (pid <= 0 || (::kill(pid, 0) == 0 || errno != ESRCH)) continue;
    const std::string path = directory + "/" + name;
    if (server_is_dead(path)) ::unlink(path.c_str());
  }
  ::closedir(opened);
}

/// Returns a socket that listens at `path`. On failure, returns an empty Descriptor and sets errno,
/// which is EADDRINUSE when the file exists. @pre the caller holds the lock of the directory.
Descriptor bind_and_listen(const std::string& path, mode_t mode) {
  sockaddr_un address{};
  if (!address_of(path, address)) {
    errno = ENAMETOOLONG;
    return {};
  }
  Descriptor socket = new_socket();
  if (!socket ||
      ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return {};
  }
  if (::chmod(path.c_str(), mode) != 0 || ::listen(socket.get(), SOMAXCONN) != 0) {
    const int why = errno;
    ::unlink(path.c_str());
    errno = why;
    return {};
  }
  return socket;
}

void say_goodbye(int socket, std::string_view why, ControlType type = ControlType::Bye) {
  ControlMessage bye{.type = type};
  bye.set_text(why);
  send_control(socket, bye);
}

}  // namespace

std::string well_known_path(const std::string& directory, std::string_view name) {
  return directory + "/" + file_name(name) + ".sock";
}

Descriptor connect_to(const std::string& path) {
  sockaddr_un address{};
  if (!address_of(path, address)) {
    errno = ENAMETOOLONG;
    return {};
  }
  Descriptor socket = new_socket();
  if (!socket) return {};
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    return socket;
  }
  const int why = errno;
  socket.reset();
  errno = why;
  return {};
}

tl::expected<std::unique_ptr<Acceptor>, MediumError> ShmAcceptor::open(const ShmOptions& options,
                                                                       std::string_view name,
                                                                       bool well_known) {
  const std::string& directory = options.directory;
  if (auto prepared = prepare_directory(directory); !prepared) {
    return tl::unexpected(std::move(prepared.error()));
  }
  auto lock = DirectoryLock::take(directory);
  if (!lock) return tl::unexpected(std::move(lock.error()));
  sweep(directory);

  const mode_t mode = open_to_all_users(directory) ? 0666 : 0600;
  std::string path = well_known_path(directory, name);
  Descriptor listener;
  if (well_known) {
    listener = bind_and_listen(path, mode);
    if (!listener && errno == EADDRINUSE) {
      if (server_is_dead(path)) ::unlink(path.c_str());
      listener = bind_and_listen(path, mode);
      if (!listener && errno == EADDRINUSE) return listen_error(occupied(path));
    }
  } else {
    static std::atomic<std::uint64_t> opened{0};  // makes the addresses of this process unique
    do {  // the same pid in another process namespace may have taken the name
      path = directory + "/" + file_name(name) + "." + std::to_string(::getpid()) + "." +
             std::to_string(++opened) + ".sock";
      listener = bind_and_listen(path, mode);
    } while (!listener && errno == EADDRINUSE);
  }
  if (!listener) {
    return listen_error("cannot listen at " + path + ": " + system_text(errno));
  }
  try {
    return std::make_unique<ShmAcceptor>(path, std::move(listener));
  } catch (const std::system_error&) {
    ::unlink(path.c_str());
    throw;
  }
}

ShmAcceptor::ShmAcceptor(std::string path, Descriptor listener)
    : path_(std::move(path)),
      address_("shm:" + path_),
      listener_(std::move(listener)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      spare_(::open("/dev/null", O_RDONLY | O_CLOEXEC)),
      descriptors_{epoll_.get()},
      fork_watch_(this, [](void* owner) noexcept { static_cast<ShmAcceptor*>(owner)->abandon(); }) {
  join_barriers();  // now, because the first call may take long, and accept() must not wait
  for (const int descriptor : {listener_.get(), more_.descriptor()}) {
    epoll_event event{EPOLLIN, {.fd = descriptor}};
    if (epoll_ && ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, descriptor, &event) == 0) continue;
    throw_system_error("epoll for " + path_, errno);
  }
}

ShmAcceptor::~ShmAcceptor() {
  if (inherited_) return;
  ::unlink(path_.c_str());
  while (let_in()) {  // accepts the clients in the backlog, to notify them too
  }
  for (const PendingPeer& pending : pending_)
    say_goodbye(pending.socket.get(), "the server closed");
}

const Capabilities& ShmAcceptor::capabilities() const { return shm_capabilities; }

std::unique_ptr<Connection> ShmAcceptor::accept() {
  if (inherited_) return nullptr;
  short_of_descriptors_ = false;
  std::array<epoll_event, 16> events;
  const int count = ::epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), 0);
  if (count <= 0) return nullptr;
  more_.drain();
  for (std::size_t pending = pending_.size(); pending-- > 0;) {
    if (auto connection = hear(pending)) return connection;
  }
  // A client sends its Hello message right after it connects, so that most of these messages can be
  // read right after accept4().
  for (int i = 0; i < most_at_once; ++i) {
    if (!let_in()) return nullptr;
    if (pending_.empty()) continue;
    if (auto connection = hear(pending_.size() - 1)) return connection;
  }
  more_.notify();  // an edge-triggered watcher would get no further event
  return nullptr;
}

bool ShmAcceptor::let_in() {
  PendingPeer pending;
  pending.socket =
      Descriptor(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!pending.socket) return none_left(errno) && turn_away();
  auto peer = peer_of(pending.socket.get());
  if (!peer) {
    say_goodbye(pending.socket.get(), "refused: " + peer.error());
    return true;
  }
  if (const std::string why = why_not(*peer); !why.empty()) {
    say_goodbye(pending.socket.get(), why, ControlType::Refuse);
    log_info("shm", path_ + " refused " + peer->description + ": " + why);
    return true;
  }
  auto death = death_of_peer(pending.socket.get(), *peer->pid);
  if (!death) return true;  // the client is dead: nobody is left to notify
  epoll_event event{EPOLLIN, {.fd = pending.socket.get()}};
  if (::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, pending.socket.get(), &event) != 0) return true;
  pending.peer = std::move(*peer);
  pending.death = std::move(*death);
  if (pending_.size() == most_pending) drop(0);  // drops the oldest client without Hello
  pending_.push_back(std::move(pending));
  return true;
}

/// Returns why the user of `peer` is not admitted; an empty text when the user is admitted.
std::string ShmAcceptor::why_not(const Peer& peer) const {
  if (peer.uid == ::geteuid() || peer.uid == 0u) return "";
  if (admit_) return admit_(peer);
  return "this server admits only uid " + std::to_string(::geteuid());
}

/// Refuses a waiting client when the process has no descriptor left. Returns false when no client
/// was waiting, or when another thread took the descriptor that was freed for this purpose.
bool ShmAcceptor::turn_away() {
  // The client must be accepted in order to be refused. If it stayed in the backlog, the listener
  // would stay readable and keep this thread awake.
  spare_.reset();
  const Descriptor unwanted(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
  short_of_descriptors_ = !unwanted && none_left(errno);
  if (unwanted) say_goodbye(unwanted.get(), no_descriptors);
  spare_ = Descriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  if (unwanted) log_turned_away();
  return static_cast<bool>(unwanted);
}

void ShmAcceptor::log_turned_away() const {
  log_warning(
      "shm",
      path_ + " refused a client: this process has no file descriptors left; raise `ulimit -n`");
}

std::unique_ptr<Connection> ShmAcceptor::hear(std::size_t index) {
  PendingPeer& pending = pending_[index];
  ReceivedControl hello;
  const ControlRead read = receive_control(pending.socket.get(), hello);
  if (read == ControlRead::Nothing) return nullptr;
  if (read != ControlRead::Message || hello.message.type != ControlType::Hello) {
    if (read == ControlRead::Garbage) {
      say_goodbye(pending.socket.get(),
                  "refused: the client uses another version of gecos, or is no gecos program");
    } else if (read == ControlRead::NoDescriptors) {
      say_goodbye(pending.socket.get(), no_descriptors);
      log_turned_away();
    }
    drop(index);
    return nullptr;
  }
  ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, pending.socket.get(), nullptr);
  const std::string who = pending.peer.description;
  auto connection = ShmConnection::welcome(std::move(pending.socket), std::move(pending.peer),
                                           std::move(pending.death), hello);
  pending_.erase(pending_.begin() + static_cast<std::ptrdiff_t>(index));
  if (connection) return std::move(*connection);
  log_warning("shm", path_ + " refused " + who + ": " + connection.error());
  return nullptr;
}

void ShmAcceptor::drop(std::size_t pending) {
  pending_.erase(pending_.begin() + static_cast<std::ptrdiff_t>(pending));
}

std::unique_ptr<StreamWriter> ShmAcceptor::make_stream(std::size_t largest, std::size_t depth) {
  return make_shared_stream(largest, depth);
}

void ShmAcceptor::abandon() noexcept {
  inherited_ = true;
  listener_.reset();
  epoll_.reset();
  more_.close();
  spare_.reset();
  for (PendingPeer& pending : pending_) {
    pending.socket.reset();
    pending.death.reset();
  }
}

}  // namespace gecos::media::shm
