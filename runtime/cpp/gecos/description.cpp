#include "gecos/description.hpp"

#include <algorithm>

namespace gecos {
namespace {

template <class Table>
auto find_by_code(const Table& table, FunctionCode code) -> decltype(table.data()) {
  const auto at =
      std::lower_bound(table.begin(), table.end(), code,
                       [](const auto& entry, FunctionCode wanted) { return entry.code < wanted; });
  return at != table.end() && at->code == code ? &*at : nullptr;
}

}  // namespace

const OperationDescription* InterfaceDescription::find(FunctionCode code) const {
  return find_by_code(operations, code);
}

const StreamDescription* InterfaceDescription::find_stream(FunctionCode code) const {
  return find_by_code(streams, code);
}

bool InterfaceDescription::is_a(std::string_view interface_name) const {
  return name == interface_name ||
         std::find(bases.begin(), bases.end(), interface_name) != bases.end();
}

}  // namespace gecos
