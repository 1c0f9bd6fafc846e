// The reads of tests/vectors/decoder.json with the C++ decoder. tests/python/wire_reads.py does the
// same with Python's.
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <variant>

#include "gecos/wire/decoder.hpp"
#include "json.hpp"

namespace gecos::wire {
namespace {

using gecos::testing::Json;

/// Printed the same way as `printed(Json)` prints what is expected.
template <typename T>
std::string printed(T number) {
  std::ostringstream text;
  if constexpr (std::is_floating_point_v<T>) {
    text << std::hex << std::bit_cast<std::uint64_t>(static_cast<double>(number));
  } else {
    text << +number;
  }
  return text.str();
}

bool is_floating(const std::string& get) { return get == "double" || get == "float"; }

std::string expected(const Json& read, const Json& value) {
  const std::string& get = read["get"].text;
  if (value.kind == Json::Kind::List) {
    std::string text = "[";
    for (std::size_t i = 0; i < value.items.size(); ++i) {
      const Json element = get == "block"
                               ? read["reads"].items[i]
                               : Json::from_text("{\"get\":\"" + read["of"].text + "\"}");
      text += expected(element, value.items[i]) + ",";
    }
    return text + "]";
  }
  return is_floating(get) ? printed(value.number()) : value.text;
}

const char* field_of(const Json& read) {
  return read.has("field") ? read["field"].text.c_str() : "";
}

template <typename T>
bool get_number(Decoder& in, const Json& read, std::string& value) {
  T number{};
  if (!in.get(number, field_of(read))) return false;
  value = std::is_same_v<T, bool> ? (number ? "true" : "false") : printed(number);
  return true;
}

template <typename T>
bool get_numbers(Decoder& in, const Json& read, std::string& value) {
  std::size_t count = read.has("count") ? read["count"].natural() : 0;
  const std::size_t max = read.has("max") ? read["max"].natural() : npos;
  if (read["get"].text == "counted" && !in.get_count(count, sizeof(T), max, field_of(read))) {
    return false;
  }
  std::vector<T> numbers(count);
  if (!in.get_array(numbers, field_of(read))) return false;
  value = "[";
  for (const T number : numbers) value += printed(number) + ",";
  value += "]";
  return true;
}

bool get_all(Decoder& in, const Json& reads, std::string& values);

bool get_one(Decoder& in, const Json& read, std::string& value) {
  using Get = bool (*)(Decoder&, const Json&, std::string&);
  static const std::map<std::string, Get> getters{
      {"bool", get_number<bool>},
      {"int8", get_number<std::int8_t>},
      {"uint8", get_number<std::uint8_t>},
      {"int16", get_number<std::int16_t>},
      {"uint16", get_number<std::uint16_t>},
      {"int32", get_number<std::int32_t>},
      {"uint32", get_number<std::uint32_t>},
      {"int64", get_number<std::int64_t>},
      {"uint64", get_number<std::uint64_t>},
      {"float", get_number<float>},
      {"double", get_number<double>},
  };
  const std::string& get = read["get"].text;
  const std::size_t max = read.has("max") ? read["max"].natural() : npos;
  if (get == "string") return in.get_string(value, max, field_of(read));
  if (get == "count") {
    std::size_t count = 0;
    if (!in.get_count(count, read["min"].natural(), max, field_of(read))) return false;
    value = printed(count);
    return true;
  }
  if (get == "array" || get == "counted") {
    return read["of"].text == "double" ? get_numbers<double>(in, read, value)
                                       : get_numbers<std::int16_t>(in, read, value);
  }
  if (get == "block") {
    Decoder inner;
    return in.open_block(inner, field_of(read)) &&
           (get_all(inner, read["reads"], value), in.close_block(inner));
  }
  if (get == "enter") {
    value = "null";
    return in.enter(field_of(read));
  }
  if (get == "end") return in.expect_end();
  return getters.at(get)(in, read, value);
}

bool get_all(Decoder& in, const Json& reads, std::string& values) {
  values = "[";
  for (const Json& read : reads.items) {
    std::string value;
    if (!get_one(in, read, value)) return false;
    if (read["get"].text != "end") values += value + ",";
  }
  values += "]";
  return true;
}

std::string problem_name(DecodeProblem problem) {
  switch (problem) {
    case DecodeProblem::Truncated:
      return "Truncated";
    case DecodeProblem::InvalidBoolean:
      return "InvalidBoolean";
    case DecodeProblem::NegativeCount:
      return "NegativeCount";
    case DecodeProblem::OverBound:
      return "OverBound";
    case DecodeProblem::MissingNul:
      return "MissingNul";
    case DecodeProblem::NulInString:
      return "NulInString";
    case DecodeProblem::InvalidUtf8:
      return "InvalidUtf8";
    case DecodeProblem::TooDeep:
      return "TooDeep";
    case DecodeProblem::TrailingBytes:
      return "TrailingBytes";
    default:
      return describe(problem);
  }
}

void expect_verdict(const Json& json, const Json& reads) {
  const Bytes bytes = json["bytes"].bytes();
  Decoder in(bytes);
  std::string values;
  const bool accepted = get_all(in, reads, values);
  if (json.has("values")) {
    ASSERT_TRUE(accepted) << in.error().message();
    std::string wanted = "[";
    for (std::size_t i = 0; i < json["values"].items.size(); ++i) {
      wanted += expected(reads.items[i], json["values"].items[i]) + ",";
    }
    EXPECT_EQ(values, wanted + "]");
  } else {
    ASSERT_FALSE(accepted);
    EXPECT_EQ(problem_name(in.error().problem), json["refused"]["problem"].text);
    EXPECT_EQ(in.error().offset, json["refused"]["offset"].natural());
    EXPECT_EQ(in.error().field, json["refused"]["field"].text);
  }
}

void expect_verdicts(const std::string& section) {
  const Json vectors = Json::from_vectors("decoder.json");
  ASSERT_FALSE(vectors[section].items.empty());
  for (const Json& json : vectors[section].items) {
    SCOPED_TRACE(json["name"].text);
    expect_verdict(json, json.has("reads") ? json["reads"] : vectors["mutation_reads"]);
  }
}

TEST(DecoderVectors, GoodBytesAreRead) { expect_verdicts("accepted"); }
TEST(DecoderVectors, BadBytesAreRefusedForTheRightReason) { expect_verdicts("refused"); }
TEST(DecoderVectors, MutatedBytesGetTheVerdictThatPythonGave) { expect_verdicts("mutations"); }

}  // namespace
}  // namespace gecos::wire
