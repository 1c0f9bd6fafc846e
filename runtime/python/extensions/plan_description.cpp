#include "plan_description.hpp"

#include <nanobind/stl/pair.h>
#include <structmember.h>

#include <memory>
#include <string>
#include <unordered_map>

namespace gecos::python::plans {
namespace {

namespace nb = nanobind;

std::unordered_map<PyTypeObject*, std::unique_ptr<Plan>>& plans() {
  static auto& all = *new std::unordered_map<PyTypeObject*, std::unique_ptr<Plan>>();
  return all;
}

const Plan& demanded(nb::handle kind) {
  const Plan* const plan = plan_of(reinterpret_cast<PyTypeObject*>(kind.ptr()));
  if (plan == nullptr)
    throw nb::type_error((nb::repr(kind).c_str() + std::string(" has no plan")).c_str());
  return *plan;
}

char code_of(nb::handle given) {
  const std::string code = nb::cast<nb::str>(given).c_str();
  if (code.size() != 1 || size_of(code.front()) == 0) {
    throw nb::type_error(("'" + code + "' is not the type code of a number").c_str());
  }
  return code.front();
}

Limits limits_of(char code, nb::handle low, nb::handle high) {
  Limits limits;
  limits.there = !low.is_none() || !high.is_none();
  if (code == 'f' || code == 'd') {
    if (!low.is_none()) limits.low = PyFloat_AsDouble(low.ptr());
    if (!high.is_none()) limits.high = PyFloat_AsDouble(high.ptr());
  } else {
    if (!low.is_none()) limits.least = PyLong_AsLongLong(low.ptr());
    if (!high.is_none()) limits.most = PyLong_AsLongLong(high.ptr());
  }
  if (PyErr_Occurred() != nullptr) throw nb::python_error();
  return limits;
}

Py_ssize_t size_or_counted(nb::handle size) {
  return size.is_none() ? -1 : PyLong_AsSsize_t(size.ptr());
}

Step step_of(nb::handle given);

void describe_numbers(Step& step, const nb::tuple& given) {
  step.code = code_of(given[1]);
  step.least = size_of(step.code);
  if (step.what == What::Array) {
    step.size = 1;
    for (const nb::handle each : nb::cast<nb::tuple>(given[2])) {
      step.shape.push_back(PyLong_AsSsize_t(each.ptr()));
      step.size *= step.shape.back();
    }
  } else {
    step.most = PyLong_AsSsize_t(nb::handle(given[2]).ptr());
  }
  step.limits = limits_of(step.code, given[3], given[4]);
  if (step.limits.there && step.code != 'd') {
    throw nb::type_error("in a plan, only arrays of doubles may have limits");
  }
}

void describe_enumerator(Step& step, const nb::tuple& given) {
  step.code = code_of(given[1]);
  step.kind = reinterpret_cast<PyTypeObject*>(nb::object(given[2]).release().ptr());
  nb::dict known;
  for (const nb::handle each : nb::handle(reinterpret_cast<PyObject*>(step.kind))) {
    known[nb::int_(each)] = each;
  }
  step.known = known.release().ptr();
  if (!nb::handle(given[3]).is_none()) step.otherwise = nb::object(given[3]).release().ptr();
}

void describe_items(Step& step, const nb::tuple& given) {
  step.inner.push_back(step_of(given[1]));
  step.least = PyLong_AsSsize_t(nb::handle(given[2]).ptr());
  step.size = size_or_counted(given[3]);
  step.most = PyLong_AsSsize_t(nb::handle(given[4]).ptr());
  if (step.least < 1) throw nb::type_error("each item of a plan must take at least one byte");
}

Step step_of(nb::handle given) {
  Step step;
  if (nb::isinstance<nb::str>(given)) {
    step.code = code_of(given);
    if (step.code == 'd') step.what = What::Double;
    return step;
  }
  const auto parts = nb::cast<nb::tuple>(given);
  const std::string what = nb::cast<nb::str>(parts[0]).c_str();
  if (what == "ranged") {
    step.code = code_of(parts[1]);
    step.limits = limits_of(step.code, parts[2], parts[3]);
    if (step.code == 'Q' || step.code == '?')
      throw nb::type_error("in a plan, numbers of the type codes 'Q' and '?' may not have limits");
  } else if (what == "enumerator") {
    step.what = What::Enumerator;
    describe_enumerator(step, parts);
  } else if (what == "array" || what == "numbers") {
    step.what = what == "array" ? What::Array : What::Numbers;
    describe_numbers(step, parts);
  } else if (what == "text") {
    step.what = What::Text;
    step.most = PyLong_AsSsize_t(nb::handle(parts[1]).ptr());
  } else if (what == "octets") {
    step.what = What::Octets;
    step.least = 1;
    step.size = size_or_counted(parts[1]);
    step.most = PyLong_AsSsize_t(nb::handle(parts[2]).ptr());
  } else if (what == "struct" || what == "block") {
    step.what = what == "struct" ? What::Struct : What::Block;
    step.plan = &demanded(parts[1]);
  } else if (what == "optional") {
    step.what = What::Optional;
    step.inner.push_back(step_of(parts[1]));
  } else if (what == "items") {
    step.what = What::Items;
    describe_items(step, parts);
  } else {
    throw nb::type_error(("a plan has no kind of step that is called " + what).c_str());
  }
  if (PyErr_Occurred() != nullptr) throw nb::python_error();
  return step;
}

Py_ssize_t least_of(const Step& step) {
  switch (step.what) {
    case What::Double:
    case What::Number:
    case What::Enumerator:
      return size_of(step.code);
    case What::Struct:
      return step.plan->least;
    case What::Block:
      return 4 + step.plan->least;
    case What::Text:
      return 5;
    case What::Optional:
      return 1;
    default:
      return step.size < 0 ? 4 : step.size * step.least;
  }
}

}  // namespace

Py_ssize_t slot_of(nb::handle kind, const char* name) {
  const nb::object slot = kind.attr(name);
  if (Py_TYPE(slot.ptr()) == &PyMemberDescr_Type) {
    const auto* const member = reinterpret_cast<PyMemberDescrObject*>(slot.ptr())->d_member;
    if (member->type == T_OBJECT_EX) return member->offset;
  }
  throw nb::type_error((std::string(name) + " is not a slot").c_str());
}

const Plan& describe(nb::handle kind, std::uint64_t fingerprint, const nb::sequence& members,
                     const nb::sequence& defaults, bool open) {
  auto plan = std::make_unique<Plan>();
  plan->kind = reinterpret_cast<PyTypeObject*>(kind.ptr());
  plan->fingerprint = fingerprint;
  plan->open = open;
  for (const nb::handle member : members) {
    const auto [name, step] = nb::cast<std::pair<nb::object, nb::object>>(member);
    plan->slots.push_back(slot_of(kind, nb::cast<nb::str>(name).c_str()));
    plan->steps.push_back(step_of(step));
    plan->least += least_of(plan->steps.back());
  }
  for (const nb::handle each : defaults) plan->defaults.push_back(nb::borrow(each).release().ptr());
  if (plan->defaults.size() > plan->steps.size())
    throw nb::type_error("a plan has more defaults than members");
  nb::borrow(kind).release();  // never released, like the plan
  return *plans().insert_or_assign(plan->kind, std::move(plan)).first->second;
}

const Plan* plan_of(PyTypeObject* kind) {
  const auto found = plans().find(kind);
  return found == plans().end() ? nullptr : found->second.get();
}

}  // namespace gecos::python::plans
