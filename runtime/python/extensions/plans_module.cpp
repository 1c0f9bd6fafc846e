#include <nanobind/nanobind.h>

#include "plan_callables.hpp"
#include "plan_description.hpp"

namespace {

namespace nb = nanobind;
namespace plans = gecos::python::plans;

nb::object owned(PyObject* object) {
  if (object == nullptr) throw nb::python_error();
  return nb::steal(object);
}

}  // namespace

NB_MODULE(_plans, module) {
  module.doc() = "Compiled codecs of generated structs; `gecos.wire.plans` uses them.";
  module.def(
      "prepare",
      [](nb::handle decoder) {
        if (!plans::prepare_callables(decoder.ptr())) throw nb::python_error();
      },
      nb::arg("decoder"));
  module.def(
      "struct",
      [](nb::handle kind, std::uint64_t fingerprint, const nb::sequence& members,
         const nb::sequence& defaults, bool open, nb::handle encode, nb::handle decode) {
        const plans::Plan& plan = plans::describe(kind, fingerprint, members, defaults, open);
        return nb::make_tuple(owned(plans::encoding(plan, encode.ptr())),
                              owned(plans::decoding(plan, decode.ptr())));
      },
      nb::arg("kind"), nb::arg("fingerprint"), nb::arg("members"), nb::arg("defaults"),
      nb::arg("open"), nb::arg("encode"), nb::arg("decode"));
  module.def(
      "from_start",
      [](nb::handle decode, nb::handle python) {
        return owned(plans::from_start(decode.ptr(), python.ptr()));
      },
      nb::arg("decode"), nb::arg("python"));
  module.def(
      "entry",
      [](const char* name, nb::handle python) { return owned(plans::entry(name, python.ptr())); },
      nb::arg("name"), nb::arg("python"));
}
