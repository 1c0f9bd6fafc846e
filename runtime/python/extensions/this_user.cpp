// Functions for the commands that show and check the runtime directory and the keys of this user.
// They use the code of the runtime, so that commands and runtime follow the same rules.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <stdexcept>

#include "bind.hpp"
#include "gecos/audit/folder.hpp"
#include "gecos/crypto/key_directory.hpp"
#include "gecos/crypto/key_file.hpp"
#include "gecos/media/shm/directory.hpp"

namespace gecos::python {
namespace {

namespace nb = nanobind;

std::optional<std::string> runtime_directory_problem() {
  auto prepared = media::shm::prepare_directory(media::shm::default_runtime_directory());
  if (prepared) return std::nullopt;
  return std::move(prepared.error().text);
}

crypto::KeyDirectory keys() {
  auto opened = crypto::KeyDirectory::open();
  if (!opened) throw std::runtime_error(opened.error().text);
  return *std::move(opened);
}

std::string own_key() {
  const auto identity = keys().identity();
  if (!identity) throw std::runtime_error(identity.error().text);
  return identity->public_key().to_string();
}

std::optional<std::string> key_problem(const std::string& key) {
  const auto parsed = crypto::PublicKey::parse(key);
  if (!parsed) throw nb::value_error(("'" + key + "' is not a key of 64 hex digits").c_str());
  const auto admitted = keys().admission(*parsed);
  if (admitted) return std::nullopt;
  return admitted.error().text;
}

std::optional<std::string> key_owner(const std::string& key) {
  const auto parsed = crypto::PublicKey::parse(key);
  if (!parsed) throw nb::value_error(("'" + key + "' is not a key of 64 hex digits").c_str());
  const auto owner = keys().owner(*parsed);
  if (!owner) throw std::runtime_error(owner.error().text);
  if (!*owner) return std::nullopt;
  return (*owner)->user + "@" + (*owner)->host;
}

bool is_key_owner(const std::string& text) { return crypto::KeyOwner::parse(text).has_value(); }

std::string public_key_in(const nb::bytes& text) {
  const auto* const bytes = static_cast<const std::byte*>(text.data());
  const auto key = crypto::read_key_file(crypto::KeyFileKind::PublicKey, {bytes, text.size()});
  if (!key) throw nb::value_error(std::string(key.error()).c_str());
  return crypto::PublicKey::of(key->bytes()).to_string();
}

}  // namespace

void bind_this_user(nb::module_& module) {
  module.def("runtime_directory", &media::shm::default_runtime_directory);
  module.def("runtime_directory_problem", &runtime_directory_problem);
  module.def("audit_directory", &audit::default_folder);
  module.def("key_directory", &crypto::KeyDirectory::default_path);
  module.def("own_key", &own_key);
  module.def("key_problem", &key_problem, nb::arg("key"));
  module.def("key_owner", &key_owner, nb::arg("key"));
  module.def("is_key_owner", &is_key_owner, nb::arg("text"));
  module.def("public_key_in", &public_key_in, nb::arg("text"));
}

}  // namespace gecos::python
