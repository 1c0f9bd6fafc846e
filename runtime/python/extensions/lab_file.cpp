// Functions that read a lab file as servers and clients do, for `gecos up`, `gecos policy` and
// `gecos doctor`.
#include "gecos/access/lab_file.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>

#include <stdexcept>

#include "bind.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/kinds.hpp"
#include "waiting.hpp"

namespace gecos::python {
namespace {

namespace nb = nanobind;
using User = std::pair<std::string, std::string>;

std::optional<std::string> lab_file_problem(const std::string& text, const std::string& file) {
  const auto lists = access::parse_lab_file(text, file, media::all_names());
  if (lists) return std::nullopt;
  return to_string(lists.error());
}

std::pair<bool, std::string> may_connect(const std::string& text, const std::string& file,
                                         const User& server, const User& who,
                                         const std::string& object) {
  auto lists = access::parse_lab_file(text, file, media::all_names());
  if (!lists) throw nb::value_error(to_string(lists.error()).c_str());
  const access::AccessPolicy policy{.lab = *std::move(lists)};
  auto decision = policy.decide({server.first, server.second}, {who.first, who.second}, object);
  return {decision.allowed(), std::move(decision.text)};
}

std::pair<bool, std::string> may_register(const std::string& text, const std::string& file,
                                          const User& who, const std::string& name) {
  const auto lists = access::parse_lab_file(text, file, media::all_names());
  if (!lists) throw nb::value_error(to_string(lists.error()).c_str());
  auto decision = access::may_register(*lists, name, access::UserAtHost{who.first, who.second});
  return {decision.allowed, std::move(decision.text)};
}

std::string forbids_open_streams(const std::string& text, const std::string& file) {
  const auto lists = access::parse_lab_file(text, file, media::all_names());
  if (!lists) throw nb::value_error(to_string(lists.error()).c_str());
  return lists->forbids_open_streams;
}

/// Returns the address of the broker that the lab file of this program names, and the place of this
/// address in the file. Both are empty if there is no lab file, or if it names no address.
std::pair<std::string, std::string> broker_in_lab_file(double patience) {
  auto found = without_gil(
      [patience = patience_of(patience)] { return session::broker_in_lab_file(patience); });
  if (!found) throw std::runtime_error(found.error());
  return {std::move(found->address), std::move(found->place)};
}

}  // namespace

void bind_lab_file(nb::module_& module) {
  module.def("lab_file_problem", &lab_file_problem, nb::arg("text"), nb::arg("file"));
  module.def("broker_in_lab_file", &broker_in_lab_file, nb::arg("patience"));
  module.def("may_connect", &may_connect, nb::arg("text"), nb::arg("file"), nb::arg("server"),
             nb::arg("who"), nb::arg("object"));
  module.def("may_register", &may_register, nb::arg("text"), nb::arg("file"), nb::arg("who"),
             nb::arg("name"));
  module.def("forbids_open_streams", &forbids_open_streams, nb::arg("text"), nb::arg("file"));
}

}  // namespace gecos::python
