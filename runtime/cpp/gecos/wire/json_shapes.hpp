// The representation of each kind of value in JSON. Generated files `<file>_json.cpp` add the
// declared types. This header does not include the header of the JSON library, which takes seconds
// to compile.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "gecos/wire/contents.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::wire {

/// The error for a JSON value that does not fit the C++ type. It has the path of the wrong value,
/// for example "joints[2].speed", and the reason.
struct JsonError {
  std::string path;
  std::string why;

  std::string message() const { return path.empty() ? why : path + ": " + why; }
  friend bool operator==(const JsonError&, const JsonError&) = default;
};
inline std::string describe(const JsonError& error) { return error.message(); }

/// The name and the number of an enumerator or a flag.
struct JsonName {
  std::string_view name;
  std::uint64_t number;
};
using JsonNames = std::span<const JsonName>;
using MemberNames = std::span<const std::string_view>;

class JsonWriter;
class JsonReader;

/// The functions that write and read a value of type T: `write(JsonWriter, const T&)` and `bool
/// read(const JsonReader&, T&)`.
template <class T>
struct JsonShape;

/// The functions of a JsonShape, for code that does not know the type of the value. Such code is
/// compiled only once for all structs.
struct JsonKind {
  void (*write)(JsonWriter to, const void* value);
  bool (*read)(const JsonReader& from, void* value);
};
template <class T>
void write_json_of(JsonWriter to, const void* value);
template <class T>
bool read_json_of(const JsonReader& from, void* value);
template <class T>
inline constexpr JsonKind json_kind{&write_json_of<T>, &read_json_of<T>};

/// Writes a value to its place in a JSON document.
class JsonWriter {
 public:
  explicit JsonWriter(nlohmann::ordered_json& place) : place_(&place) {}

  void put(bool value) const;
  void put(char letter) const;
  void put(std::int64_t value) const;
  void put(std::uint64_t value) const;
  void put(double value) const;
  void put(std::string_view text) const;
  void put_null() const;
  void put_name(JsonNames names, std::uint64_t number) const;
  void put_flags(JsonNames flags, std::uint64_t bits) const;

  void open_object() const;
  void open_list() const;
  /// Returns a writer for the member `name` of an open object. The writer is valid until the next
  /// member is added.
  JsonWriter at(std::string_view name) const;
  /// Returns a writer for a new element of an open list. The writer is valid until a further
  /// element is added.
  JsonWriter item() const;

  template <class T>
  void member(std::string_view name, const T& value) const {
    member(name, &value, json_kind<T>);
  }
  void member(std::string_view name, const void* value, const JsonKind& kind) const;
  void hidden_member(std::string_view name) const;

 private:
  nlohmann::ordered_json* place_;
};

/// Reads a JSON value and knows the path of this value in its document. When a function returns
/// false, it has set the error, and the caller must stop. A reader keeps pointers to the JSON
/// value, to the error, and to the readers of the enclosing values. This class has more methods
/// than other classes, because it has one for each kind of value that generated code reads.
class JsonReader {
 public:
  JsonReader(const nlohmann::json& data, JsonError& error) : data_(&data), error_(&error) {}

  bool get(bool& value) const;
  bool get(char& letter) const;
  bool get(float& value) const;
  bool get(double& value) const;
  bool get(std::string& text) const;
  bool get_whole(std::int64_t& value, std::size_t bytes) const;
  bool get_whole(std::uint64_t& value, std::size_t bytes) const;
  bool get_name(JsonNames names, std::uint64_t& number) const;
  bool get_flags(JsonNames flags, std::uint64_t& bits) const;
  bool is_null() const;

  bool expect_list(std::size_t& count) const;
  bool expect_items(std::size_t count) const;
  bool expect_pair() const;
  JsonReader item(std::size_t index) const;
  /// Returns a reader for the key (`index` 0) or the value (`index` 1) of a pair. An error in this
  /// reader shows the path of the pair.
  JsonReader half(std::size_t index) const;

  /// Requires a JSON object that has no members other than `known`.
  bool expect_object(MemberNames known) const;
  bool expect_member(std::string_view name) const;
  bool expect_tag() const;
  /// Checks the members of a union's object. The member `value` must exist exactly when `selected`
  /// is true. No member other than `value` and `tag` may exist.
  bool expect_arm(bool selected) const;
  std::optional<JsonReader> find(std::string_view name) const;

  /// Reads a member. If the member is missing, returns true and leaves `value` unchanged.
  template <class T>
  bool member(std::string_view name, T& value) const {
    return member(name, &value, json_kind<T>);
  }
  bool member(std::string_view name, void* value, const JsonKind& kind) const;
  /// Reads a secret member. Refuses the text "***", which writers put in place of a secret.
  template <class T>
  bool hidden_member(std::string_view name, T& value) const {
    return hidden_member(name, &value, json_kind<T>);
  }
  bool hidden_member(std::string_view name, void* value, const JsonKind& kind) const;

  bool fail(std::string why) const;
  JsonError& error() const { return *error_; }

 private:
  JsonReader(const nlohmann::json& data, const JsonReader& around, std::string_view name,
             std::size_t index)
      : data_(&data), error_(around.error_), around_(&around), name_(name), index_(index) {}
  bool is_shown() const;
  bool expect(bool fits, std::string_view wanted) const;
  std::string path() const;

  static constexpr std::size_t no_item = static_cast<std::size_t>(-1);
  const nlohmann::json* data_;
  JsonError* error_;
  const JsonReader* around_ = nullptr;
  std::string_view name_;
  std::size_t index_ = no_item;
};

/// Visits the members of a struct in order. The constructor decides whether this class collects the
/// names of the members, writes the members, or reads them.
class JsonMembers {
 public:
  JsonMembers() = default;  ///< collects the names of the members
  explicit JsonMembers(const JsonWriter& to) : to_(&to) {}
  explicit JsonMembers(const JsonReader& from) : from_(&from) {}

  template <class T>
  bool member(std::string_view name, T& value) {
    return member(name, &value, json_kind<T>);
  }
  bool member(std::string_view name, void* value, const JsonKind& kind);
  /// Visits a secret member. Its value is never written.
  template <class T>
  bool hidden_member(std::string_view name, T& value) {
    return hidden_member(name, &value, json_kind<T>);
  }
  bool hidden_member(std::string_view name, void* value, const JsonKind& kind);
  MemberNames names() const { return names_; }

 private:
  const JsonWriter* to_ = nullptr;
  const JsonReader* from_ = nullptr;
  std::vector<std::string_view> names_;
};

/// A function that calls `each` for each member of the struct at `value`, in order.
using JsonVisit = bool (*)(JsonMembers& each, void* value);
void write_json_members(JsonWriter to, JsonVisit visit, void* value);
bool read_json_members(const JsonReader& from, JsonVisit visit, void* value);

/// The JSON representation of a struct. A generated file `<file>_json.cpp` lists the members of the
/// struct.
template <class T>
struct JsonStruct {
  static void write(JsonWriter to, const T& value) {
    write_json_members(to, &visit_any, const_cast<T*>(&value));  // only reads `value`
  }
  static bool read(const JsonReader& from, T& value) {
    return read_json_members(from, &visit_any, &value);
  }

 private:
  static bool visit_any(JsonMembers& each, void* value) {
    return visit(each, *static_cast<T*>(value));
  }
  /// Visits the members of T in order; the members of the bases of T come first. Stops at the first
  /// member that is refused.
  static bool visit(JsonMembers& each, T& value);
};

/// Visits the members that a struct lists. In a label such as "open.width", the part after the
/// point is the name of the member.
class JsonListed {
 public:
  explicit JsonListed(JsonMembers& each) : each_(each) {}

  template <class T, class Step = layout::DefaultStep<T>>
  bool operator()(std::string_view label, T& value, const Step& = {}) {
    if constexpr (layout::is_secret<Step>) return each_.hidden_member(name(label), value);
    return each_.member(name(label), value);
  }
  static bool may_end() { return true; }
  static std::string_view name(std::string_view label) { return label.substr(label.find('.') + 1); }

 private:
  JsonMembers& each_;
};

/// Requires every member except those that an older writer may have omitted.
class JsonRequired {
 public:
  explicit JsonRequired(const JsonReader& from) : from_(from) {}

  template <class T, class Step = layout::DefaultStep<T>>
  bool operator()(std::string_view label, const T&, const Step& = {}) {
    return may_end_ || from_.expect_member(JsonListed::name(label));
  }
  bool may_end() { return may_end_ = true; }

 private:
  const JsonReader& from_;
  bool may_end_ = false;
};

/// The JSON representation of the arguments or the result of a call. All members are required,
/// except the members at the end that have defaults.
template <layout::Listed T>
struct JsonShape<T> {
  static void write(JsonWriter to, const T& value) {
    write_json_members(to, &visit_any, const_cast<T*>(&value));  // only reads `value`
  }
  static bool read(const JsonReader& from, T& value) {
    JsonRequired required(from);
    return read_json_members(from, &visit_any, &value) && T::gecos_members(required, value);
  }

 private:
  static bool visit_any(JsonMembers& each, void* value) {
    JsonListed listed(each);
    return T::gecos_members(listed, *static_cast<T*>(value));
  }
};

/// The JSON representation of an enum: the name of the enumerator. A generated file
/// `<file>_json.cpp` lists the names.
template <class T>
struct JsonEnum {
  static void write(JsonWriter to, T value) {
    to.put_name(names(), static_cast<std::uint64_t>(value));
  }
  static bool read(const JsonReader& from, T& value) {
    std::uint64_t number = 0;
    if (!from.get_name(names(), number)) return false;
    value = static_cast<T>(number);
    return true;
  }
  static JsonNames names();
};

/// The JSON representation of a bitmask: the list of the names of its flags. A generated file
/// `<file>_json.cpp` lists all names.
template <class T>
struct JsonFlags {
  static void write(JsonWriter to, T value) {
    to.put_flags(names(), static_cast<std::uint64_t>(value));
  }
  static bool read(const JsonReader& from, T& value) {
    std::uint64_t bits = 0;
    if (!from.get_flags(names(), bits)) return false;
    value = static_cast<T>(bits);
    return true;
  }
  static JsonNames names();
};

template <class T>
void write_json_of(JsonWriter to, const void* value) {
  JsonShape<T>::write(to, *static_cast<const T*>(value));
}
template <class T>
bool read_json_of(const JsonReader& from, void* value) {
  return JsonShape<T>::read(from, *static_cast<T*>(value));
}

template <class T>
requires(std::is_same_v<T, bool> || std::is_same_v<T, char> || std::is_same_v<T, std::string> ||
         std::is_floating_point_v<T>) struct JsonShape<T> {
  static void write(JsonWriter to, const T& value) {
    if constexpr (std::is_same_v<T, float>) {
      to.put(static_cast<double>(value));
    } else if constexpr (std::is_same_v<T, std::string>) {
      to.put(std::string_view(value));
    } else {
      to.put(value);
    }
  }
  static bool read(const JsonReader& from, T& value) { return from.get(value); }
};

template <std::integral T>
requires(!std::is_same_v<T, bool> && !std::is_same_v<T, char>) struct JsonShape<T> {
  using Wide = std::conditional_t<std::is_signed_v<T>, std::int64_t, std::uint64_t>;
  static void write(JsonWriter to, T value) { to.put(static_cast<Wide>(value)); }
  static bool read(const JsonReader& from, T& value) {
    Wide wide = 0;
    if (!from.get_whole(wide, sizeof(T))) return false;
    value = static_cast<T>(wide);
    return true;
  }
};

template <class T>
struct JsonShape<std::optional<T>> {
  static void write(JsonWriter to, const std::optional<T>& value) {
    if (!value) return to.put_null();
    JsonShape<T>::write(to, *value);
  }
  static bool read(const JsonReader& from, std::optional<T>& value) {
    value.reset();
    return from.is_null() || JsonShape<T>::read(from, value.emplace());
  }
};

template <class T>
struct JsonShape<std::vector<T>> {
  static void write(JsonWriter to, const std::vector<T>& value) {
    to.open_list();
    for (const T& each : value) JsonShape<T>::write(to.item(), each);
  }
  static bool read(const JsonReader& from, std::vector<T>& value) {
    std::size_t count = 0;
    if (!from.expect_list(count)) return false;
    value.clear();
    value.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      T each{};
      if (!JsonShape<T>::read(from.item(i), each)) return false;
      value.push_back(std::move(each));
    }
    return true;
  }
};

template <class T, std::size_t size>
struct JsonShape<std::array<T, size>> {
  static void write(JsonWriter to, const std::array<T, size>& value) {
    to.open_list();
    for (const T& each : value) JsonShape<T>::write(to.item(), each);
  }
  static bool read(const JsonReader& from, std::array<T, size>& value) {
    if (!from.expect_items(size)) return false;
    for (std::size_t i = 0; i < size; ++i) {
      if (!JsonShape<T>::read(from.item(i), value[i])) return false;
    }
    return true;
  }
};

template <class Key, class T, class Order>
struct JsonShape<std::map<Key, T, Order>> {
  static void write(JsonWriter to, const std::map<Key, T, Order>& value) {
    to.open_list();
    for (const auto& [key, entry] : value) {
      const JsonWriter pair = to.item();
      pair.open_list();
      JsonShape<Key>::write(pair.item(), key);
      JsonShape<T>::write(pair.item(), entry);
    }
  }
  static bool read(const JsonReader& from, std::map<Key, T, Order>& value) {
    std::size_t count = 0;
    if (!from.expect_list(count)) return false;
    value.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const JsonReader pair = from.item(i);
      Key key{};
      if (!pair.expect_pair() || !JsonShape<Key>::read(pair.half(0), key)) return false;
      const auto [place, fresh] = value.try_emplace(std::move(key));
      if (!fresh) return pair.fail("the map already has this key");
      if (!JsonShape<T>::read(pair.half(1), place->second)) return false;
    }
    return true;
  }
};

/// The JSON representation of a union. A generated function returns the member that a discriminator
/// (tag) selects.
template <class T>
requires requires(const T& value) {
  typename T::Held;
  T::gecos_arm(value.tag);
}
struct JsonShape<T> {
  static void write(JsonWriter to, const T& value) {
    to.open_object();
    to.member("tag", value.tag);
    if (is_secret(value.value.index())) return to.hidden_member("value");
    std::visit(
        [&](const auto& held) {
          if constexpr (!std::is_same_v<decltype(held), const std::monostate&>) {
            to.member("value", held);
          }
        },
        value.value);
  }
  static bool read(const JsonReader& from, T& value) {
    if (!from.expect_tag() || !from.member("tag", value.tag)) return false;
    const std::size_t arm = T::gecos_arm(value.tag);
    value.value = std::monostate{};
    return from.expect_arm(arm != 0) && read_arm<1>(from, value, arm);
  }

 private:
  template <std::size_t index>
  static bool read_arm(const JsonReader& from, T& value, std::size_t arm) {
    if constexpr (index == std::variant_size_v<typename T::Held>) {
      return true;
    } else {
      if (arm != index) return read_arm<index + 1>(from, value, arm);
      auto& held = value.value.template emplace<index>();
      return is_secret(index) ? from.hidden_member("value", held) : from.member("value", held);
    }
  }
  static constexpr bool is_secret([[maybe_unused]] std::size_t arm) {
    if constexpr (requires { T::gecos_secret(arm); }) {
      return T::gecos_secret(arm);
    } else {
      return false;
    }
  }
};

/// Maps the hand-written type `T` to the struct that the interface declares for it.
template <class T>
struct JsonLayout;

/// Writes a value of a hand-written type in the form of `Layout`, the declared struct, which has
/// the same encoding.
template <class Layout, GeneralContents T>
void write_json_as(JsonWriter to, const T& value) {
  const auto layout = from_bytes<Layout>(to_bytes(value));
  if (!layout) return to.put_null();
  JsonShape<Layout>::write(to, *layout);
}
template <class Layout, GeneralContents T>
bool read_json_as(const JsonReader& from, T& value) {
  Layout layout;
  if (!JsonShape<Layout>::read(from, layout)) return false;
  auto made = from_bytes<T>(to_bytes(layout));
  if (!made) return from.fail("not a valid value of its type");
  value = std::move(*made);
  return true;
}

}  // namespace gecos::wire
