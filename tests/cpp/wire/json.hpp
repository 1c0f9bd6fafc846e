// Reads the shared vectors of tests/vectors. Enough of JSON for them; anything else throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "gecos/base/bytes.hpp"

namespace gecos::testing {

class Json {
 public:
  enum class Kind { Null, Boolean, Number, String, List, Object };

  static Json from_text(const std::string& text);

  /// A file of tests/vectors by its name.
  static Json from_vectors(const std::string& name);

  Kind kind = Kind::Null;
  std::string text;               ///< of a string, or a number or boolean as written
  std::vector<Json> items;        ///< of a list, or the values of an object
  std::vector<std::string> keys;  ///< of an object, in the order of `items`

  bool has(const std::string& key) const;
  const Json& operator[](const std::string& key) const;  ///< throws when there is none
  double number() const;  ///< also of NaN and Infinity, as Python writes them
  std::int64_t integer() const;
  std::uint64_t natural() const;
  std::vector<double> numbers() const;
  Bytes bytes() const;  ///< of a string of hex digits
};

Bytes from_hex(const std::string& digits);
std::string to_hex(ByteView bytes);

}  // namespace gecos::testing
