#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <exception>
#include <system_error>

#include "bind.hpp"
#include "fork_generation.hpp"
#include "gecos/command.hpp"

namespace {

void as_os_error(const std::exception_ptr& raised, void*) {
  try {
    std::rethrow_exception(raised);
  } catch (const std::system_error& failed) {
    const auto arguments = nanobind::make_tuple(failed.code().value(), failed.what());
    PyErr_SetObject(PyExc_OSError, arguments.ptr());
  }
}

}  // namespace

NB_MODULE(_core, module) {
  module.doc() =
      "The C++ runtime, with values as encoded bytes. The modules of `gecos` add the types.";
  nanobind::register_exception_translator(as_os_error);
  gecos::python::count_forks();
  gecos::python::bind_client(module);
  gecos::python::bind_lab_file(module);
  gecos::python::bind_server(module);
  gecos::python::bind_this_user(module);
  module.def("detail_name", [](std::uint8_t number) {
    const auto detail = gecos::detail_from(number);
    return std::string(detail ? gecos::to_string(*detail) : "");
  });
  // Proxies and servers in global variables live until the interpreter has ended. nanobind must not
  // report them as leaks, because `gecos.shutdown` has closed their sessions before.
  nanobind::set_leak_warnings(false);
}
