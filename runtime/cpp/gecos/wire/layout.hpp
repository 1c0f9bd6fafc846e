// Structs that list their members once: the arguments and the result of a call. Their size, codec,
// checks and JSON are derived from the list.
//
//     struct Gripper_open_arguments {
//       double width = 0;
//
//       static bool gecos_members(auto& each, auto& self) {
//         return each("open.width", self.width, gecos::layout::Ranged<double>{{.low = 0}, "…"});
//       }
//     };
//
// The parameters of `each` are the label of a member in error texts, the member, and the *step* of
// the member, which says how the member is encoded. Without a step, the type of the member decides.
// `each.may_end()` stands before the members that an older writer may omit. Python has the same
// steps in gecos.wire.layout.
#pragma once

#include <array>
#include <cassert>
#include <concepts>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "gecos/wire/check.hpp"
#include "gecos/wire/contents.hpp"
#include "gecos/wire/fields.hpp"

namespace gecos::layout {

/// True if arrays of T are byte-swapped in one pass.
template <class T>
inline constexpr bool in_bulk = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

/// A bitset or bitmask, which is encoded as one number: a type with the member function `bits` and
/// without `encoded_size`. The second condition excludes a union that has an arm with the name
/// `bits`.
template <class T>
concept Packed = requires(const T& value) {
  value.bits();
}
&&!requires(const T& value) { value.encoded_size(); };

/// The default encoding of a member that is a number, an enumerator, a text without bound, or a
/// value that encodes itself.
struct Plain {
  template <class T>
  static constexpr std::size_t least() {
    if constexpr (std::is_same_v<T, std::string>) return 5;
    if constexpr (Packed<T>) {
      return sizeof(decltype(std::declval<const T&>().bits()));
    }
    return sizeof(T);
  }
  template <class T>
  static std::size_t size(const T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      return 5 + value.size();
    } else if constexpr (requires { value.encoded_size(); }) {
      return value.encoded_size();
    } else {
      return least<T>();
    }
  }
  template <class T>
  static void put(wire::Encoder& to, const T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      to.put_string(value);
    } else if constexpr (std::is_enum_v<T>) {
      to.put(static_cast<std::make_signed_t<std::underlying_type_t<T>>>(value));
    } else if constexpr (Packed<T>) {
      to.put(value.bits());
    } else {
      wire::put_plain(to, value);
    }
  }
  template <class T>
  static bool get(wire::Decoder& from, T& value, const char* label) {
    if constexpr (std::is_same_v<T, std::string>) {
      return from.get_string(value, wire::npos, label);
    } else if constexpr (std::is_arithmetic_v<T>) {
      return from.get(value, label);
    } else if constexpr (requires { value.decode(from); }) {
      return value.decode(from);
    } else {
      return decode_enum(from, value, label);
    }
  }
  template <class T>
  static std::string wrong(const T& value, [[maybe_unused]] const char* label) {
    if constexpr (std::is_same_v<T, std::string>) {
      return wire::valid_text(value) ? std::string() : wire::bad_text(label);
    } else {
      return wire::violation_of(value);
    }
  }
};

/// The encoding of an element of a sequence or map. The element encodes itself, in at least `bytes`
/// bytes.
template <std::size_t bytes>
struct Value : Plain {
  template <class T>
  static constexpr std::size_t least() {
    return bytes;
  }
};

/// The encoding of an @appendable value: first the size of the value, then its members.
struct Block : Plain {
  template <class T>
  static constexpr std::size_t least() {
    return 4;
  }
  template <class T>
  static std::size_t size(const T& value) {
    return 4 + value.encoded_size();
  }
  template <class T>
  static void put(wire::Encoder& to, const T& value) {
    wire::put_block(to, value, value.encoded_size());
  }
  template <class T>
  static bool get(wire::Decoder& from, T& value, const char* label) {
    return wire::get_block(from, value, label);
  }
};

/// The encoding of a text of at most `bound` bytes.
template <std::size_t bound>
struct Text : Plain {
  static bool get(wire::Decoder& from, std::string& text, const char* label) {
    return from.get_string(text, bound, label);
  }
  static std::string wrong(const std::string& text, const char* label) {
    if (text.size() > bound) return wire::over_bound(label, text.size(), bound, "bytes");
    return Plain::wrong(text, label);
  }
};

/// The encoding of a number within `bounds`. `limits` is the text of the bounds in errors, for
/// example "[0.01, 1.0] m/s".
template <class T>
struct Ranged : Plain {
  constexpr Ranged(wire::Bounds<T> allowed, const char* shown) : bounds(allowed), limits(shown) {}

  bool get(wire::Decoder& from, T& number, const char* label) const {
    return from.get(number, label) && wire::within(from, number, bounds, label, limits);
  }
  std::string wrong(T number, const char* label) const {
    return bounds.hold(number) ? std::string() : wire::out_of_range(label, number, limits);
  }

  wire::Bounds<T> bounds;
  const char* limits;
};

template <class T>
struct StepOf {
  using type = Plain;
};
/// The encoding of a member of type T, if the member has no bound, no range and contains no
/// @appendable value.
template <class T>
using DefaultStep = typename StepOf<T>::type;

/// The encoding of a secret member, which equals that of `Step`. JSON does not show the value of
/// the member.
template <class Step>
struct Secret : Step {
  constexpr Secret() = default;
  constexpr explicit Secret(Step hidden) : Step(hidden) {}
};

template <class Step>
inline constexpr bool is_secret = false;
template <class Step>
inline constexpr bool is_secret<Secret<Step>> = true;

/// Returns the error of an element of a nested array. The text contains no index, because such an
/// element has several indices.
template <class Step, class T>
std::string wrong_inside(const Step& step, const T& value, const char* label) {
  if constexpr (requires { step.wrong(value, label, true); }) {
    return step.wrong(value, label, true);
  } else {
    return step.wrong(value, label);
  }
}

/// The encoding of an optional value.
template <class Step>
struct Optional {
  constexpr Optional() = default;
  constexpr explicit Optional(Step inner) : step(inner) {}

  template <class T>
  static constexpr std::size_t least() {
    return 1;
  }
  template <class T>
  std::size_t size(const std::optional<T>& value) const {
    return 1 + (value ? step.size(*value) : 0);
  }
  template <class T>
  void put(wire::Encoder& to, const std::optional<T>& value) const {
    to.put(value.has_value());
    if (value) step.put(to, *value);
  }
  template <class T>
  bool get(wire::Decoder& from, std::optional<T>& value, const char* label) const {
    return wire::get_optional(from, value, label,
                              [&](T& inner) { return step.get(from, inner, label); });
  }
  template <class T>
  std::string wrong(const std::optional<T>& value, const char* label, bool inside = false) const {
    if (!value) return {};
    return inside ? wrong_inside(step, *value, label) : step.wrong(*value, label);
  }

  Step step;
};

/// The common base of `Array` and `Items`, whose elements are all encoded by one step.
template <class Step>
struct Elements {
  constexpr Elements() = default;
  constexpr explicit Elements(Step element) : step(element) {}

  template <class Range>
  std::size_t size_of_all(const Range& values) const {
    using T = typename Range::value_type;
    if constexpr (in_bulk<T>) return values.size() * sizeof(T);
    std::size_t size = 0;
    for (const auto& each : values) size += step.size(each);
    return size;
  }
  template <class Range>
  void put_all(wire::Encoder& to, const Range& values) const {
    if constexpr (in_bulk<typename Range::value_type>) {
      to.put_array(values);
    } else {
      for (const auto& each : values) step.put(to, each);
    }
  }
  template <class Range>
  bool all_hold(wire::Decoder& from, const Range& values, const char* label) const {
    if constexpr (requires { step.bounds; }) {
      return wire::all_within(from, values, step.bounds, label, step.limits);
    }
    return true;
  }
  template <class Range>
  std::string wrong(const Range& values, const char* label, bool inside = false) const {
    if constexpr (requires { step.bounds; }) {
      const auto* const outlier = wire::first_outside(values, step.bounds);
      if (outlier == nullptr) return {};
      if (inside) return step.wrong(*outlier, label);
      return wire::element_out_of_range(label, values, outlier, step.limits);
    } else if constexpr (!in_bulk<typename Range::value_type>) {
      for (const auto& each : values) {
        if (auto why = wrong_inside(step, each, label); !why.empty()) return why;
      }
    }
    return {};
  }

  Step step;
};

/// The encoding of an array of fixed size.
template <class Step>
struct Array : Elements<Step> {
  constexpr Array() = default;
  constexpr explicit Array(Step element) : Elements<Step>(element) {}

  template <class T>
  static constexpr std::size_t least() {
    return std::tuple_size_v<T> * Step::template least<typename T::value_type>();
  }
  template <class T>
  std::size_t size(const T& values) const {
    return this->size_of_all(values);
  }
  template <class T>
  void put(wire::Encoder& to, const T& values) const {
    this->put_all(to, values);
  }
  template <class T>
  bool get(wire::Decoder& from, T& values, const char* label) const {
    if constexpr (in_bulk<typename T::value_type>) {
      return from.get_array(values, label) && this->all_hold(from, values, label);
    } else {
      return wire::get_each(values, [&](auto& each) { return this->step.get(from, each, label); });
    }
  }
};

/// The encoding of a sequence of at most `bound` elements.
template <class Step, std::size_t bound = wire::npos>
struct Items : Elements<Step> {
  constexpr Items() = default;
  constexpr explicit Items(Step element) : Elements<Step>(element) {}

  template <class T>
  static constexpr std::size_t least() {
    return 4;
  }
  template <class T>
  std::size_t size(const std::vector<T>& values) const {
    return 4 + this->size_of_all(values);
  }
  template <class T>
  void put(wire::Encoder& to, const std::vector<T>& values) const {
    to.put_count(values.size());
    this->put_all(to, values);
  }
  template <class T>
  bool get(wire::Decoder& from, std::vector<T>& values, const char* label) const {
    if constexpr (in_bulk<T>) {
      return wire::get_numbers(from, values, bound, label) && this->all_hold(from, values, label);
    } else {
      return wire::get_sequence(from, values, Step::template least<T>(), bound, label,
                                [&](auto& each) { return this->step.get(from, each, label); });
    }
  }
  template <class T>
  std::string wrong(const std::vector<T>& values, const char* label, bool inside = false) const {
    if (values.size() > bound) return wire::over_bound(label, values.size(), bound, "elements");
    return Elements<Step>::wrong(values, label, inside);
  }
};

/// The encoding of a map of at most `bound` entries.
template <class KeyStep, class ValueStep, std::size_t bound = wire::npos>
struct Entries {
  constexpr Entries() = default;
  constexpr Entries(KeyStep of_keys, ValueStep of_values) : key_step(of_keys), step(of_values) {}

  template <class T>
  static constexpr std::size_t least() {
    return 4;
  }
  template <class Map>
  std::size_t size(const Map& entries) const {
    std::size_t size = 4;
    for (const auto& [key, entry] : entries) size += key_step.size(key) + step.size(entry);
    return size;
  }
  template <class Map>
  void put(wire::Encoder& to, const Map& entries) const {
    to.put_count(entries.size());
    for (const auto& [key, entry] : entries) {
      key_step.put(to, key);
      step.put(to, entry);
    }
  }
  template <class Map>
  bool get(wire::Decoder& from, Map& entries, const char* label) const {
    constexpr std::size_t least_each = KeyStep::template least<typename Map::key_type>() +
                                       ValueStep::template least<typename Map::mapped_type>();
    return wire::get_map(
        from, entries, least_each, bound, label,
        [&](auto& key) { return key_step.get(from, key, label); },
        [&](auto& entry) { return step.get(from, entry, label); });
  }
  template <class Map>
  std::string wrong(const Map& entries, const char* label) const {
    if (entries.size() > bound) {
      return wire::over_bound(label, entries.size(), bound, "entries");
    }
    for (const auto& [key, entry] : entries) {
      if (auto why = wrong_inside(key_step, key, label); !why.empty()) return why;
      if (auto why = wrong_inside(step, entry, label); !why.empty()) return why;
    }
    return {};
  }

  KeyStep key_step;
  ValueStep step;
};

template <class T>
struct StepOf<std::optional<T>> {
  using type = Optional<DefaultStep<T>>;
};
template <class T>
struct StepOf<std::vector<T>> {
  using type = Items<DefaultStep<T>>;
};
template <class T, std::size_t size>
struct StepOf<std::array<T, size>> {
  using type = Array<DefaultStep<T>>;
};
template <class Key, class T, class Order>
struct StepOf<std::map<Key, T, Order>> {
  using type = Entries<DefaultStep<Key>, DefaultStep<T>>;
};

// ---------------------------------------------------------------------------------------------
// The types of `each`

class Sizing {
 public:
  template <class T, class Step = DefaultStep<T>>
  bool operator()(const char*, const T& value, const Step& step = {}) {
    size += step.size(value);
    return true;
  }
  static bool may_end() { return true; }

  std::size_t size = 0;
};

class Writing {
 public:
  explicit Writing(wire::Encoder& to) : to_(to) {}
  template <class T, class Step = DefaultStep<T>>
  bool operator()(const char*, const T& value, const Step& step = {}) {
    step.put(to_, value);
    return true;
  }
  static bool may_end() { return true; }

 private:
  wire::Encoder& to_;
};

/// Decodes the members. @pre all members have their default values.
class Reading {
 public:
  explicit Reading(wire::Decoder& from) : from_(from) {}
  template <class T, class Step = DefaultStep<T>>
  bool operator()(const char* label, T& value, const Step& step = {}) {
    return (may_end_ && from_.at_end()) || step.get(from_, value, label);
  }
  bool may_end() { return may_end_ = true; }

 private:
  wire::Decoder& from_;
  bool may_end_ = false;
};

/// Finds the first member whose value must not be sent.
class Checking {
 public:
  template <class T, class Step = DefaultStep<T>>
  bool operator()(const char* label, const T& value, const Step& step = {}) {
    why = step.wrong(value, label);
    return why.empty();
  }
  static bool may_end() { return true; }

  std::string why;
};

/// A struct that lists its members.
template <class T>
concept Listed = std::default_initializable<T> && requires(Sizing& each, const T& value) {
  { T::gecos_members(each, value) } -> std::same_as<bool>;
};

template <Listed T>
std::size_t encoded_size(const T& value) {
  Sizing each;
  T::gecos_members(each, value);
  return each.size;
}

/// Encodes the members of `value`, which take exactly `encoded_size(value)` bytes.
template <Listed T>
void encode(wire::Encoder& to, const T& value) {
  Writing each(to);
  T::gecos_members(each, value);
}

/// Decodes the members of `value`. Skips members that a newer writer appended. Members that an
/// older writer omitted get their default values.
template <Listed T>
[[nodiscard]] bool decode(wire::Decoder& from, T& value) {
  value = T{};
  Reading each(from);
  return T::gecos_members(each, value) && wire::skip_rest(from);
}

/// Returns the error text of the first member whose value must not be sent. The text names the
/// member, and is empty when `value` may be sent.
template <Listed T>
std::string violation(const T& value) {
  Checking each;
  T::gecos_members(each, value);
  return std::move(each.why);
}

template <Listed T>
Bytes to_bytes(const T& value) {
  Bytes bytes(encoded_size(value));
  wire::Encoder encoder(bytes);
  encode(encoder, value);
  assert(encoder.written() == bytes.size());
  return bytes;
}

/// Decodes the result of `to_bytes`.
template <Listed T>
tl::expected<T, wire::DecodeError> from_bytes(ByteView bytes) {
  tl::expected<T, wire::DecodeError> result;
  wire::Decoder decoder(bytes);
  if (!decode(decoder, *result)) return tl::make_unexpected(decoder.error());
  return result;
}

/// The result of a call of an operation that has a single result.
template <class T, class Step = DefaultStep<T>>
struct Result {
  T result{};

  static bool gecos_members(auto& each, auto& self) {
    if constexpr (requires { result.has_value(); }) each.may_end();
    return each("result", self.result, Step{});
  }
};

}  // namespace gecos::layout
