#include "gecos/media/shm/memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "gecos/base/system_error.hpp"

namespace gecos::media::shm {
namespace {

constexpr int seals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;

}  // namespace

tl::expected<SealedMemory, MediumError> make_sealed(const char* name, std::size_t size) {
  const auto failed = [&](const char* what) {
    return tl::unexpected(MediumError{"shm: " + std::string(what) + " of " + std::to_string(size) +
                                      " bytes failed: " + system_text(errno)});
  };
  SealedMemory memory;
  memory.memfd = Descriptor(::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!memory.memfd) return failed("memfd_create");
  if (::ftruncate(memory.memfd.get(), static_cast<off_t>(size)) != 0) return failed("ftruncate");
  memory.mapping = Mapping::shared(memory.memfd.get(), size, true);
  if (!memory.mapping) return failed("mmap");
  // The memory is sealed after this process has mapped it, because F_SEAL_FUTURE_WRITE forbids only
  // later mappings for writing.
  if (::fcntl(memory.memfd.get(), F_ADD_SEALS, seals) != 0) return failed("sealing");
  return memory;
}

tl::expected<Mapping, NotMapped> map_received(int memfd, std::size_t size) {
  const auto invalid = [](const char* text) {
    return tl::unexpected(NotMapped{NotMapped::Cause::InvalidMemory, text});
  };
  const int found = ::fcntl(memfd, F_GET_SEALS);
  if (found < 0 || (found & seals) != seals) {
    return invalid("the peer sent memory that is not sealed");
  }
  struct stat status {};
  if (::fstat(memfd, &status) != 0 || status.st_size < 0 ||
      static_cast<std::size_t>(status.st_size) != size) {
    return invalid("the peer sent memory of another size than agreed");
  }
  Mapping mapping = Mapping::shared(memfd, size, false);
  if (!mapping) {
    return tl::unexpected(
        NotMapped{NotMapped::Cause::NoRoom, "this process cannot map " + std::to_string(size) +
                                                " bytes (see `ulimit -v`): " + system_text(errno)});
  }
  return mapping;
}

}  // namespace gecos::media::shm
