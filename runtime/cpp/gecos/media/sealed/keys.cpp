#include "gecos/media/sealed/keys.hpp"

#include <utility>

namespace gecos::media {

tl::expected<std::shared_ptr<const SealedKeys>, MediumError> SealedKeys::open(
    const std::string& path) {
  const auto failed = [](const crypto::KeyError& error) {
    return tl::unexpected(MediumError{error.text});
  };
  auto directory =
      crypto::KeyDirectory::open(path.empty() ? crypto::KeyDirectory::default_path() : path);
  if (!directory) return failed(directory.error());
  auto own = directory->identity();
  if (!own) return failed(own.error());
  return std::make_shared<const SealedKeys>(SealedKeys{std::move(*directory), std::move(*own)});
}

}  // namespace gecos::media
