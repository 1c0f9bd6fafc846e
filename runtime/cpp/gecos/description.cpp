#include "gecos/description.hpp"

#include <algorithm>

namespace gecos {
namespace {

template <class Entry>
using Table = std::span<const Entry> InterfaceDescription::*;

template <class Entry>
const Entry* find_by_code(const InterfaceDescription& interface, Table<Entry> table,
                          FunctionCode code) {
  const auto own = interface.*table;
  const auto at = std::ranges::lower_bound(own, code, {}, &Entry::code);
  if (at != own.end() && at->code == code) return &*at;
  for (const InterfaceDescription* base : interface.inherits) {
    if (const Entry* inherited = find_by_code(*base, table, code)) return inherited;
  }
  return nullptr;
}

template <class Entry>
void collect(const InterfaceDescription& interface, Table<Entry> table,
             std::vector<const Entry*>& into) {
  for (const Entry& entry : interface.*table) into.push_back(&entry);
  for (const InterfaceDescription* base : interface.inherits) collect(*base, table, into);
}

template <class Entry>
std::vector<const Entry*> all_by_code(const InterfaceDescription& interface, Table<Entry> table) {
  std::vector<const Entry*> all;
  collect(interface, table, all);
  std::ranges::sort(all, {}, &Entry::code);
  // A base that is inherited on two paths was collected twice, so duplicates are removed. (clang 14
  // does not compile libstdc++'s std::ranges::unique.)
  const auto same = [](const Entry* one, const Entry* other) { return one->code == other->code; };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  return all;
}

void collect_models(const InterfaceDescription& interface, std::vector<std::string_view>& into) {
  const bool known = std::ranges::find(into, interface.model) != into.end();
  if (!interface.model.empty() && !known) into.push_back(interface.model);
  for (const InterfaceDescription* base : interface.inherits) collect_models(*base, into);
}

}  // namespace

const OperationDescription* InterfaceDescription::find(FunctionCode code) const {
  return find_by_code(*this, &InterfaceDescription::operations, code);
}

const StreamDescription* InterfaceDescription::find_stream(FunctionCode code) const {
  return find_by_code(*this, &InterfaceDescription::streams, code);
}

const InwardDescription* InterfaceDescription::find_inward_stream(FunctionCode code) const {
  return find_by_code(*this, &InterfaceDescription::inward_streams, code);
}

std::vector<const OperationDescription*> InterfaceDescription::all_operations() const {
  return all_by_code(*this, &InterfaceDescription::operations);
}

std::vector<const StreamDescription*> InterfaceDescription::all_streams() const {
  return all_by_code(*this, &InterfaceDescription::streams);
}

std::vector<const InwardDescription*> InterfaceDescription::all_inward_streams() const {
  return all_by_code(*this, &InterfaceDescription::inward_streams);
}

std::vector<std::string_view> InterfaceDescription::all_models() const {
  std::vector<std::string_view> models;
  collect_models(*this, models);
  return models;
}

bool InterfaceDescription::is_a(std::string_view interface_name) const {
  return name == interface_name ||
         std::find(bases.begin(), bases.end(), interface_name) != bases.end();
}

}  // namespace gecos
