#include "gecos/crypto/key_directory.hpp"

#include <fcntl.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "gecos/base/log.hpp"
#include "gecos/crypto/key_file.hpp"

namespace gecos::crypto {
namespace {

constexpr ::mode_t open_to_others = S_IRWXG | S_IRWXO;
constexpr ::mode_t writable_by_others = S_IWGRP | S_IWOTH;
constexpr const char* how_to_move = "; set GECOS_KEY_DIR to use another directory";

tl::unexpected<KeyError> fail(const std::string& path, const std::string& what) {
  return tl::unexpected(KeyError{path + ": " + what});
}
tl::unexpected<KeyError> fail_with_errno(const std::string& path, const std::string& what) {
  const bool passing = errno == EMFILE || errno == ENFILE || errno == ENOMEM;
  return tl::unexpected(
      KeyError{path + ": " + what + " (" + std::strerror(errno) + ")" + how_to_move, passing});
}

class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  explicit operator bool() const { return descriptor_ >= 0; }
  int get() const { return descriptor_; }

 private:
  const int descriptor_;
};

/// Returns an error text when the file `found` belongs to another user, or when other users have
/// one of the permissions `bits`. Returns nothing otherwise. `mend` is the file mode that the text
/// recommends.
std::optional<std::string> not_ours(const struct stat& found, ::mode_t bits, const char* mend) {
  if (found.st_uid != ::geteuid()) {
    return "belongs to uid " + std::to_string(found.st_uid) + ", but this program runs as uid " +
           std::to_string(::geteuid()) + how_to_move;
  }
  if ((found.st_mode & bits) != 0) {
    return std::string("is open to other users: run `chmod ") + mend + "` on it";
  }
  return std::nullopt;
}

/// Creates a directory and its missing parents, like mkdir -p. Only this user may access the new
/// directories. Sets errno when it returns false.
bool make_directories(const std::string& path) {
  if (::mkdir(path.c_str(), S_IRWXU) == 0 || errno == EEXIST) return true;
  const auto slash = path.find_last_of('/');
  if (errno != ENOENT || slash == std::string::npos || slash == 0) return false;
  return make_directories(path.substr(0, slash)) &&
         (::mkdir(path.c_str(), S_IRWXU) == 0 || errno == EEXIST);
}

bool write_all(int to, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ::ssize_t written = ::write(to, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

/// Creates the file `path` with the contents `text`; creates no file if it cannot write the whole
/// text. Sets errno when it returns false; errno is EEXIST when the file exists already.
bool put_file(const std::string& path, const std::string& directory, const KeyText& text) {
  const std::string fresh =
      directory + "/.new-" + KeyPair::draw().public_key.short_name() + std::to_string(::getpid());
  const File file(::open(fresh.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW,
                         S_IRUSR | S_IWUSR));
  if (!file) return false;
  // Uses link(), because rename() would replace a file that another process has created.
  const bool done = ::fchmod(file.get(), S_IRUSR | S_IWUSR) == 0 &&
                    write_all(file.get(), text.bytes()) && ::fsync(file.get()) == 0 &&
                    ::link(fresh.c_str(), path.c_str()) == 0;
  const int problem = errno;
  ::unlink(fresh.c_str());
  errno = problem;
  return done;
}

/// The users who may read a file of the directory, in addition to its owner.
enum class Readers : std::uint8_t { Nobody, Others };

/// Reads at most `into.size()` bytes of the file `path`, and returns how many. The result is an
/// empty optional when there is no such file.
tl::expected<std::optional<std::size_t>, KeyError> read_bytes(const std::string& path,
                                                              Readers readers,
                                                              std::span<std::byte> into) {
  const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!file) {
    if (errno == ENOENT) return std::optional<std::size_t>();
    return fail_with_errno(path, "cannot be read");
  }
  struct stat found {};
  if (::fstat(file.get(), &found) != 0) return fail_with_errno(path, "cannot be examined");
  if (!S_ISREG(found.st_mode)) return fail(path, "is not a regular file: remove it");
  if (readers == Readers::Nobody) {
    if (const auto why = not_ours(found, open_to_others, "600")) {
      return fail(path, *why +
                            "; if another user may have read the key, remove the file instead, "
                            "and a new key will be created");
    }
  } else if (const auto why = not_ours(found, writable_by_others, "600")) {
    return fail(path, *why);
  }
  std::size_t size = 0;
  while (size < into.size()) {
    const ::ssize_t got = ::read(file.get(), into.data() + size, into.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail_with_errno(path, "cannot be read");
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  return std::optional(size);
}

/// Reads the key in the file `path`. The result is an empty optional when there is no such file.
tl::expected<std::optional<Secret<key_bytes>>, KeyError> read_file(const std::string& path,
                                                                   KeyFileKind kind) {
  Secret<key_file_bytes + 1> text;
  const auto readers = kind == KeyFileKind::SecretKey ? Readers::Nobody : Readers::Others;
  const auto size = read_bytes(path, readers, text.bytes());
  if (!size) return tl::unexpected(size.error());
  if (!*size) return std::optional<Secret<key_bytes>>();
  auto key = read_key_file(kind, std::span<const std::byte>(text.bytes()).first(**size));
  if (!key) {
    return fail(path,
                std::string(key.error()) +
                    (kind == KeyFileKind::SecretKey
                         ? ": restore the file, or remove it to get a new key (then every user "
                           "who admitted the old key must admit the new key)"
                         : ": copy it again, or remove it"));
  }
  return std::optional(*key);
}

}  // namespace

std::string KeyDirectory::default_path() {
  const auto set = [](const char* name) -> std::optional<std::string> {
    const char* const value = std::getenv(name);
    if (value == nullptr || *value == '\0') return std::nullopt;
    return value;
  };
  if (const auto chosen = set("GECOS_KEY_DIR")) return *chosen;
  if (const auto config = set("XDG_CONFIG_HOME")) return *config + "/gecos/keys";
  if (const auto home = set("HOME")) return *home + "/.config/gecos/keys";
  std::array<char, 4096> names;
  struct passwd entry {};
  struct passwd* found = nullptr;
  if (::getpwuid_r(::geteuid(), &entry, names.data(), names.size(), &found) == 0 &&
      found != nullptr) {
    return std::string(found->pw_dir) + "/.config/gecos/keys";
  }
  // KeyDirectory::open() refuses this directory when other users have access to it.
  return "/tmp/gecos-keys-" + std::to_string(::geteuid());
}

tl::expected<KeyDirectory, KeyError> KeyDirectory::open(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  if (!make_directories(path)) return fail_with_errno(path, "the key directory cannot be created");
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) return fail_with_errno(path, "cannot be examined");
  if (!S_ISDIR(found.st_mode)) {
    return fail(path, std::string("is not a directory") + how_to_move);
  }
  if (const auto why = not_ours(found, open_to_others, "700"))
    return fail(path, "the key directory " + *why);
  return KeyDirectory(std::move(path));
}

tl::expected<Identity, KeyError> KeyDirectory::identity() const {
  const std::string secret_path = path_ + "/own.secret";
  auto secret = read_file(secret_path, KeyFileKind::SecretKey);
  if (secret && !*secret) {
    const KeyPair drawn = KeyPair::draw();
    const KeyText text = key_file_text(KeyFileKind::SecretKey, drawn.secret.bytes());
    if (!put_file(secret_path, path_, text) && errno != EEXIST) {
      return fail_with_errno(secret_path, "the key cannot be written");
    }
    // Another process may have created the file first. Therefore the key is read from the file.
    secret = read_file(secret_path, KeyFileKind::SecretKey);
    if (secret && !*secret)
      return fail(secret_path, "the key file was removed right after its creation; try again");
  }
  if (!secret) return tl::unexpected(secret.error());
  const KeyPair pair = KeyPair::of(**secret);
  // A failure to write the file with the public key is only logged, because the program works
  // without this file, and the directory may be read-only. The user gives this file to other users.
  const std::string public_path = path_ + "/" + pair.public_key.to_string() + ".public";
  if (::access(public_path.c_str(), F_OK) != 0 &&
      !put_file(public_path, path_, key_file_text(KeyFileKind::PublicKey, pair.public_key.bytes)) &&
      errno != EEXIST) {
    log_warning("crypto", public_path + ": the file with your public key cannot be written: " +
                              std::strerror(errno));
  }
  return Identity(pair);
}

tl::expected<void, KeyError> KeyDirectory::admission(const PublicKey& key) const {
  const std::string name = key.to_string() + ".public";
  const auto refused = [&](const std::string& why, bool passing = false) {
    return tl::unexpected(
        KeyError{"the key " + key.short_name() + " is not admitted here: " + why, passing});
  };
  const auto found = read_file(path_ + "/" + name, KeyFileKind::PublicKey);
  if (!found) return refused(found.error().text, found.error().passing);
  if (!*found) {
    return refused("to admit this key into " + path_ + ", get the file " + name +
                   " from its user and run `gecos keys add " + name +
                   " USER@HOST` with the name of that user and of that user's host");
  }
  if (PublicKey::of((*found)->bytes()) == key) {
    if (const auto named = owner(key); !named) {
      return refused(named.error().text, named.error().passing);
    }
    return {};
  }
  return refused(path_ + "/" + name +
                 ": the file holds another key than its name says: copy it again, or remove it");
}

std::optional<KeyOwner> KeyOwner::parse(std::string_view text) {
  const auto at = text.find('@');
  const auto allowed = [](char c) {
    return c > ' ' && c < 0x7f && c != '@' && c != '"' && c != '*';
  };
  if (at == text.npos || at == 0 || at + 1 == text.size() || text.size() > longest) {
    return std::nullopt;
  }
  KeyOwner owner{std::string(text.substr(0, at)), std::string(text.substr(at + 1))};
  if (!std::ranges::all_of(owner.user, allowed) || !std::ranges::all_of(owner.host, allowed)) {
    return std::nullopt;
  }
  return owner;
}

tl::expected<std::optional<KeyOwner>, KeyError> KeyDirectory::owner(const PublicKey& key) const {
  const std::string file = path_ + "/" + key.to_string() + ".owner";
  std::array<std::byte, KeyOwner::longest + 2> bytes;
  const auto size = read_bytes(file, Readers::Others, bytes);
  if (!size) return tl::unexpected(size.error());
  if (!*size) return std::optional<KeyOwner>();
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), **size);
  if (text.ends_with('\n')) text.remove_suffix(1);
  auto owner = KeyOwner::parse(text);
  if (!owner) {
    return fail(
        file, "does not name the owner of the key in the form \"anna@desk\"; run `gecos keys add " +
                  path_ + "/" + key.to_string() + ".public USER@HOST`");
  }
  return owner;
}

}  // namespace gecos::crypto
