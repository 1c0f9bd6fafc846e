#include "plan_callables.hpp"

#include <structmember.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string_view>

#include "gecos/wire/swap_copy.hpp"
#include "plan_arrays.hpp"
#include "plan_description.hpp"

namespace gecos::python::plans {
namespace {

struct Callable {
  PyObject_HEAD;
  vectorcallfunc call;
  PyObject* python;
  const Plan* plan;
};

PyTypeObject* method_type = nullptr;
PyTypeObject* class_method_type = nullptr;
PyTypeObject* function_type = nullptr;

struct {
  PyTypeObject* kind = nullptr;
  Py_ssize_t data = 0, offset = 0, end = 0;
} decoder;

PyObject*& slot(PyObject* object, Py_ssize_t at) {
  return *reinterpret_cast<PyObject**>(reinterpret_cast<char*>(object) + at);
}

/// Borrows the bytes of a Python object until this Source is destroyed.
class Source {
 public:
  Source() = default;
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;
  ~Source() {
    if (view_.obj != nullptr) PyBuffer_Release(&view_);
  }
  /// Borrows the bytes of `data`. Returns false when this is not possible; a Python error may then
  /// be set.
  bool open(PyObject* data) {
    if (PyBytes_CheckExact(data)) {
      first_ = reinterpret_cast<const std::byte*>(PyBytes_AS_STRING(data));
      size_ = PyBytes_GET_SIZE(data);
      return true;
    }
    if (PyObject_GetBuffer(data, &view_, PyBUF_SIMPLE) != 0) return false;
    first_ = static_cast<const std::byte*>(view_.buf);
    size_ = view_.len;
    return true;
  }
  Input all() const { return {first_, first_ + size_}; }
  bool has(Py_ssize_t offset, Py_ssize_t end) const {
    return 0 <= offset && offset <= end && end <= size_;
  }

 private:
  Py_buffer view_{};
  const std::byte* first_ = nullptr;
  Py_ssize_t size_ = 0;
};

bool append(PyObject* out, PyObject* made) {
  const Owned bytes(made);
  return bytes && PyList_Append(out, bytes.get()) == 0;
}

/// Calls the replaced Python function with all arguments of the call.
PyObject* in_python(PyObject* self, PyObject* const* given, std::size_t count, PyObject* names) {
  PyErr_Clear();
  return PyObject_Vectorcall(reinterpret_cast<Callable*>(self)->python, given, count, names);
}

/// Returns whether a call has exactly `wanted` arguments and all of them are positional.
bool plain(std::size_t count, PyObject* names, Py_ssize_t wanted) {
  return names == nullptr && PyVectorcall_NARGS(count) == wanted;
}

PyObject* call_encode(PyObject* self, PyObject* const* given, std::size_t count, PyObject* names) {
  const Plan& plan = *reinterpret_cast<Callable*>(self)->plan;
  if (plain(count, names, 2) && Py_TYPE(given[0]) == plan.kind && PyList_CheckExact(given[1]) &&
      append(given[1], encoded(plan, given[0], Frame::Bare))) {
    Py_RETURN_NONE;
  }
  return in_python(self, given, count, names);
}

/// Decodes the next value of `source` and advances `source`. Returns null when the Python codec
/// must decode the value.
PyObject* decoded_from(const Plan& plan, PyObject* source) {
  PyObject* const data = slot(source, decoder.data);
  PyObject* const offset = slot(source, decoder.offset);
  PyObject* const end = slot(source, decoder.end);
  if (data == nullptr || offset == nullptr || end == nullptr) return nullptr;
  // This reference keeps `data` alive: decoding may start a garbage collection, which may run
  // arbitrary code, and this code may release `data`.
  const Owned kept(Py_NewRef(data));
  Source bytes;
  const Py_ssize_t first = PyLong_AsSsize_t(offset);
  const Py_ssize_t last = PyLong_AsSsize_t(end);
  if (!bytes.open(data) || !bytes.has(first, last)) return nullptr;
  Input from{bytes.all().at + first, bytes.all().at + last};
  Owned value(decoded(plan, from));
  Owned after(value ? PyLong_FromSsize_t(from.at - bytes.all().at) : nullptr);
  if (!after) return nullptr;
  const Owned before(std::exchange(slot(source, decoder.offset), after.release()));
  return value.release();
}

PyObject* call_decode(PyObject* self, PyObject* const* given, std::size_t count, PyObject* names) {
  if (plain(count, names, 1) && Py_TYPE(given[0]) == decoder.kind) {
    PyObject* const value = decoded_from(*reinterpret_cast<Callable*>(self)->plan, given[0]);
    if (value != nullptr) return value;
  }
  return in_python(self, given, count, names);
}

/// Decodes a value from the beginning of bytes. Ignores the bytes after the value.
PyObject* call_from_start(PyObject* self, PyObject* const* given, std::size_t count,
                          PyObject* names) {
  if (plain(count, names, 1) && PyBytes_CheckExact(given[0])) {
    Source bytes;
    bytes.open(given[0]);
    Input from = bytes.all();
    PyObject* const value = decoded(*reinterpret_cast<Callable*>(self)->plan, from);
    if (value != nullptr) return value;
  }
  return in_python(self, given, count, names);
}

template <Frame frame>
PyObject* call_to(PyObject* self, PyObject* const* given, std::size_t count, PyObject* names) {
  const Plan* const plan = plain(count, names, 1) ? plan_of(Py_TYPE(given[0])) : nullptr;
  PyObject* const bytes = plan == nullptr ? nullptr : encoded(*plan, given[0], frame);
  return bytes != nullptr ? bytes : in_python(self, given, count, names);
}

/// Decodes a value that takes all bytes of `data`. Returns null when the Python codec must decode
/// the value.
PyObject* decoded_whole(const Plan& plan, PyObject* data, Frame frame) {
  Source bytes;
  if (!bytes.open(data)) return nullptr;
  Input from = bytes.all();
  if (frame == Frame::Message) {
    if (from.remaining() < 8) return nullptr;
    if (wire::load_big_endian<std::uint64_t>(from.at) != plan.fingerprint) return nullptr;
    from.at += 8;
  }
  Owned value(decoded(plan, from));
  return from.remaining() == 0 ? value.release() : nullptr;
}

template <Frame frame>
PyObject* call_from(PyObject* self, PyObject* const* given, std::size_t count, PyObject* names) {
  const Plan* const plan =
      plain(count, names, 2) ? plan_of(reinterpret_cast<PyTypeObject*>(given[0])) : nullptr;
  PyObject* const value = plan == nullptr ? nullptr : decoded_whole(*plan, given[1], frame);
  return value != nullptr ? value : in_python(self, given, count, names);
}

/// Implements the functions `put(value, kind, out, field)` and `put_block` of `gecos.wire`.
template <Frame frame>
PyObject* call_put(PyObject* self, PyObject* const* given, std::size_t count, PyObject* names) {
  if (plain(count, names, 4) && reinterpret_cast<PyObject*>(Py_TYPE(given[0])) == given[1] &&
      PyList_CheckExact(given[2])) {
    const Plan* const plan = plan_of(Py_TYPE(given[0]));
    if (plan != nullptr && append(given[2], encoded(*plan, given[0], frame))) Py_RETURN_NONE;
  }
  return in_python(self, given, count, names);
}

struct Entry {
  std::string_view name;
  vectorcallfunc call;
};
constexpr Entry entries[] = {
    {"to_bytes", call_to<Frame::Bare>},     {"to_message", call_to<Frame::Message>},
    {"from_bytes", call_from<Frame::Bare>}, {"from_message", call_from<Frame::Message>},
    {"put", call_put<Frame::Bare>},         {"put_block", call_put<Frame::Block>},
};

PyObject* made(PyTypeObject* type, vectorcallfunc call, const Plan* plan, PyObject* python) {
  auto* const callable = PyObject_New(Callable, type);
  if (callable == nullptr) return nullptr;
  callable->call = call;
  callable->python = Py_NewRef(python);
  callable->plan = plan;
  return reinterpret_cast<PyObject*>(callable);
}

void drop(PyObject* self) {
  PyTypeObject* const type = Py_TYPE(self);
  Py_XDECREF(reinterpret_cast<Callable*>(self)->python);
  PyObject_Free(self);
  Py_DECREF(type);
}

PyObject* bind_method(PyObject* self, PyObject* object, PyObject*) {
  return object == nullptr ? Py_NewRef(self) : PyMethod_New(self, object);
}

/// Binds the compiled `decode` to the class of the plan. For a derived class, binds the Python
/// function, because the compiled function makes only objects of the class of the plan.
PyObject* bind_class_method(PyObject* self, PyObject* object, PyObject* type) {
  const auto& mine = *reinterpret_cast<Callable*>(self);
  PyObject* const asked = type != nullptr ? type : reinterpret_cast<PyObject*>(Py_TYPE(object));
  if (asked == reinterpret_cast<PyObject*>(mine.plan->kind)) return Py_NewRef(self);
  const Owned function(PyObject_GetAttrString(mine.python, "__func__"));
  return function ? PyMethod_New(function.get(), asked) : nullptr;
}

PyTypeObject* type_of(const char* name, unsigned long flags, descrgetfunc bind) {
  static PyMemberDef members[] = {
      {"__vectorcalloffset__", T_PYSSIZET, offsetof(Callable, call), READONLY, nullptr},
      {"__wrapped__", T_OBJECT, offsetof(Callable, python), READONLY, nullptr},
      {nullptr, 0, 0, 0, nullptr},
  };
  PyType_Slot slots[] = {
      {Py_tp_members, members},
      {Py_tp_call, reinterpret_cast<void*>(PyVectorcall_Call)},
      {Py_tp_dealloc, reinterpret_cast<void*>(drop)},
      {bind == nullptr ? 0 : Py_tp_descr_get, reinterpret_cast<void*>(bind)},
      {0, nullptr},
  };
  PyType_Spec spec{name, sizeof(Callable), 0,
                   static_cast<unsigned>(Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_VECTORCALL |
                                         Py_TPFLAGS_DISALLOW_INSTANTIATION | flags),
                   slots};
  return reinterpret_cast<PyTypeObject*>(PyType_FromSpec(&spec));
}

}  // namespace

bool prepare_callables(PyObject* kind) {
  method_type = type_of("gecos.wire._plans.Method", Py_TPFLAGS_METHOD_DESCRIPTOR, bind_method);
  class_method_type = type_of("gecos.wire._plans.ClassMethod", 0, bind_class_method);
  function_type = type_of("gecos.wire._plans.Function", 0, nullptr);
  decoder.kind = reinterpret_cast<PyTypeObject*>(Py_NewRef(kind));
  decoder.data = slot_of(kind, "data");
  decoder.offset = slot_of(kind, "offset");
  decoder.end = slot_of(kind, "end");
  return method_type != nullptr && class_method_type != nullptr && function_type != nullptr;
}

PyObject* encoding(const Plan& plan, PyObject* python) {
  return made(method_type, call_encode, &plan, python);
}

PyObject* decoding(const Plan& plan, PyObject* python) {
  return made(class_method_type, call_decode, &plan, python);
}

PyObject* from_start(PyObject* decode, PyObject* python) {
  if (Py_TYPE(decode) != class_method_type) return Py_NewRef(python);
  return made(function_type, call_from_start, reinterpret_cast<Callable*>(decode)->plan, python);
}

PyObject* entry(const char* name, PyObject* python) {
  const auto* const found = std::find_if(std::begin(entries), std::end(entries),
                                         [&](const Entry& each) { return each.name == name; });
  if (found == std::end(entries)) {
    PyErr_Format(PyExc_KeyError, "gecos.wire has no compiled form of %s", name);
    return nullptr;
  }
  return made(function_type, found->call, nullptr, python);
}

}  // namespace gecos::python::plans
