#include "gecos/wire/json.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <set>

namespace gecos::wire {

namespace {

using nlohmann::json;

constexpr std::string_view hidden = "***";

std::string shown(const json& data) {
  if (data.is_null()) return "null";
  if (data.is_object()) return "an object";
  if (data.is_array()) return "a list";
  if (data.is_string()) return "a text";
  return data.is_boolean() ? "a boolean" : "a number";
}

const std::string& text_of(const json& data) { return data.get_ref<const std::string&>(); }

std::string joined(JsonNames names) {
  std::string all;
  for (const JsonName& each : names) all.append(all.empty() ? "" : ", ").append(each.name);
  return all;
}

std::string whole_numbers(bool is_signed, std::size_t bytes) {
  const auto bits = static_cast<unsigned>(8 * bytes);
  const std::string head = "a whole number from ";
  if (bits == 64) return head + (is_signed ? "-2**63 to 2**63 - 1" : "0 to 2**64 - 1");
  const auto high = (std::int64_t{1} << (is_signed ? bits - 1 : bits)) - 1;
  return head + (is_signed ? std::to_string(-high - 1) : "0") + " to " + std::to_string(high);
}

bool deeper_than(const json& data, int levels) {
  if (!data.is_structured()) return false;
  return levels == 0 || std::any_of(data.begin(), data.end(), [levels](const json& each) {
           return deeper_than(each, levels - 1);
         });
}

/// A callback for the parser that refuses an object in which a member occurs twice. Without this
/// callback, the parser would silently use the last occurrence.
class Once {
 public:
  struct Twice : std::exception {
    explicit Twice(std::string member) : name(std::move(member)) {}
    std::string name;
  };

  bool operator()(int, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::object_start) open_.emplace_back();
    if (event == json::parse_event_t::object_end) open_.pop_back();
    if (event == json::parse_event_t::key && !open_.back().insert(text_of(parsed)).second) {
      throw Twice(text_of(parsed));
    }
    return true;
  }

 private:
  std::vector<std::set<std::string>> open_;  // member names so far of each open object
};

}  // namespace

// ---------------------------------------------------------------------------------------------
// Writing

void JsonWriter::put(bool value) const { *place_ = value; }

void JsonWriter::put(char letter) const {
  const auto code = static_cast<unsigned char>(letter);
  if (code < 0x80) {
    *place_ = std::string(1, letter);
  } else {
    *place_ =
        std::string{static_cast<char>(0xC0 | (code >> 6)), static_cast<char>(0x80 | (code & 0x3F))};
  }
}

void JsonWriter::put(std::int64_t value) const { *place_ = value; }
void JsonWriter::put(std::uint64_t value) const { *place_ = value; }

void JsonWriter::put(double value) const {
  if (std::isfinite(value)) {
    *place_ = value;
  } else {
    *place_ = std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
  }
}

void JsonWriter::put(std::string_view text) const { *place_ = text; }
void JsonWriter::put_null() const { *place_ = nullptr; }

void JsonWriter::put_name(JsonNames names, std::uint64_t number) const {
  const auto found = std::find_if(names.begin(), names.end(),
                                  [number](const JsonName& each) { return each.number == number; });
  if (found == names.end()) return put(static_cast<std::int64_t>(number));
  put(found->name);
}

void JsonWriter::put_flags(JsonNames flags, std::uint64_t bits) const {
  open_list();
  for (const JsonName& flag : flags) {
    if ((bits & flag.number) == flag.number) item().put(flag.name);
  }
}

void JsonWriter::open_object() const { *place_ = nlohmann::ordered_json::object(); }
void JsonWriter::open_list() const { *place_ = nlohmann::ordered_json::array(); }

JsonWriter JsonWriter::at(std::string_view name) const {
  return JsonWriter((*place_)[std::string(name)]);
}

JsonWriter JsonWriter::item() const {
  place_->push_back(nullptr);
  return JsonWriter(place_->back());
}

void JsonWriter::member(std::string_view name, const void* value, const JsonKind& kind) const {
  kind.write(at(name), value);
}
void JsonWriter::hidden_member(std::string_view name) const { at(name).put(hidden); }

// ---------------------------------------------------------------------------------------------
// Reading

bool JsonReader::fail(std::string why) const {
  *error_ = {path(), std::move(why)};
  return false;
}

std::string JsonReader::path() const {
  if (around_ == nullptr) return "";
  std::string path = around_->path();
  if (!name_.empty()) return path.empty() ? std::string(name_) : path + "." + std::string(name_);
  return index_ == no_item ? path : path + "[" + std::to_string(index_) + "]";
}

bool JsonReader::expect(bool fits, std::string_view wanted) const {
  return fits || fail(std::string(wanted) + " is expected, " + shown(*data_) + " is there");
}

bool JsonReader::get(bool& value) const {
  if (!expect(data_->is_boolean(), "a boolean")) return false;
  value = data_->get<bool>();
  return true;
}

bool JsonReader::get(char& letter) const {
  if (!expect(data_->is_string(), "a text")) return false;
  const std::string& text = text_of(*data_);
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (text.size() == 1 && byte(0) < 0x80) {
    letter = text[0];
    return true;
  }
  const bool latin =
      text.size() == 2 && (byte(0) == 0xC2 || byte(0) == 0xC3) && (byte(1) & 0xC0) == 0x80;
  if (!latin) return fail("one character of Latin-1 is expected");
  letter = static_cast<char>(((byte(0) & 0x03) << 6) | (byte(1) & 0x3F));
  return true;
}

bool JsonReader::get(double& value) const {
  if (data_->is_string()) {
    const std::string& text = text_of(*data_);
    const double infinity = std::numeric_limits<double>::infinity();
    if (text == "nan" || text == "inf" || text == "-inf") {
      value = text == "nan" ? std::numeric_limits<double>::quiet_NaN()
                            : (text == "inf" ? infinity : -infinity);
      return true;
    }
  }
  if (!expect(data_->is_number(), "a number")) return false;
  value = data_->get<double>();
  return true;
}

bool JsonReader::get(float& value) const {
  double wide = 0;
  if (!get(wide)) return false;
  value = static_cast<float>(wide);
  if (std::isinf(value) && !std::isinf(wide)) {
    return fail(data_->dump() + " is not a number that fits in single precision");
  }
  return true;
}

bool JsonReader::get(std::string& text) const {
  if (!expect(data_->is_string(), "a text")) return false;
  text = text_of(*data_);
  return true;
}

bool JsonReader::get_whole(std::int64_t& value, std::size_t bytes) const {
  if (data_->is_number_float()) {
    return fail(data_->dump() + " is not " + whole_numbers(true, bytes));
  }
  if (!expect(data_->is_number_integer(), "a whole number")) return false;
  const auto most = std::numeric_limits<std::int64_t>::max() >> (64 - 8 * bytes);
  const bool fits = data_->is_number_unsigned()
                        ? data_->get<std::uint64_t>() <= static_cast<std::uint64_t>(most)
                        : data_->get<std::int64_t>() >= -most - 1;
  if (!fits) return fail(data_->dump() + " is not " + whole_numbers(true, bytes));
  value = data_->get<std::int64_t>();
  return data_->is_number_unsigned() || value <= most ||
         fail(data_->dump() + " is not " + whole_numbers(true, bytes));
}

bool JsonReader::get_whole(std::uint64_t& value, std::size_t bytes) const {
  if (data_->is_number_float()) {
    return fail(data_->dump() + " is not " + whole_numbers(false, bytes));
  }
  if (!expect(data_->is_number_integer(), "a whole number")) return false;
  const auto most = std::numeric_limits<std::uint64_t>::max() >> (64 - 8 * bytes);
  const bool negative = !data_->is_number_unsigned() && data_->get<std::int64_t>() < 0;
  if (negative || data_->get<std::uint64_t>() > most) {
    return fail(data_->dump() + " is not " + whole_numbers(false, bytes));
  }
  value = data_->get<std::uint64_t>();
  return true;
}

bool JsonReader::get_name(JsonNames names, std::uint64_t& number) const {
  if (!expect(data_->is_string(), "a name")) return false;
  for (const JsonName& each : names) {
    if (each.name == text_of(*data_)) {
      number = each.number;
      return true;
    }
  }
  return fail("unknown name " + text_of(*data_) + "; the known names are " + joined(names));
}

bool JsonReader::get_flags(JsonNames flags, std::uint64_t& bits) const {
  if (!expect(data_->is_array(), "a list of flags")) return false;
  bits = 0;
  for (std::size_t i = 0; i < data_->size(); ++i) {
    std::uint64_t bit = 0;
    if (!item(i).get_name(flags, bit)) return false;
    bits |= bit;
  }
  return true;
}

bool JsonReader::is_null() const { return data_->is_null(); }

bool JsonReader::expect_list(std::size_t& count) const {
  if (!expect(data_->is_array(), "a list")) return false;
  count = data_->size();
  return true;
}

bool JsonReader::expect_items(std::size_t count) const {
  std::size_t there = 0;
  if (!expect_list(there)) return false;
  return there == count || fail(std::to_string(count) + " elements are expected, " +
                                std::to_string(there) + " are there");
}

bool JsonReader::expect_pair() const {
  return (data_->is_array() && data_->size() == 2) || fail("a pair of key and value is expected");
}

JsonReader JsonReader::item(std::size_t index) const { return {(*data_)[index], *this, "", index}; }
JsonReader JsonReader::half(std::size_t index) const {
  return {(*data_)[index], *this, "", no_item};
}

bool JsonReader::expect_object(MemberNames known) const {
  if (!expect(data_->is_object(), "an object")) return false;
  for (const auto& [name, value] : data_->items()) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string why = "unknown member; the known members are ";
    for (std::size_t i = 0; i < known.size(); ++i) why.append(i == 0 ? "" : ", ").append(known[i]);
    return JsonReader(value, *this, name, no_item).fail(std::move(why));
  }
  return true;
}

bool JsonReader::expect_member(std::string_view name) const {
  return data_->contains(std::string(name)) ||
         JsonReader(*data_, *this, name, no_item).fail("it is missing");
}

bool JsonReader::expect_tag() const {
  if (!expect(data_->is_object(), "an object")) return false;
  return data_->contains("tag") || fail("the union's discriminator is missing: tag");
}

bool JsonReader::expect_arm(bool selected) const {
  for (const auto& [name, value] : data_->items()) {
    if (name == "tag" || (selected && name == "value")) continue;
    return JsonReader(value, *this, name, no_item)
        .fail("the tag of this union allows no member of this name");
  }
  return !selected || data_->contains("value") ||
         fail(
             "the member 'value' is missing: the tag of this union selects an arm, and each arm "
             "has a value");
}

std::optional<JsonReader> JsonReader::find(std::string_view name) const {
  const auto there = data_->find(std::string(name));
  if (there == data_->end()) return std::nullopt;
  return JsonReader(*there, *this, name, no_item);
}

bool JsonReader::member(std::string_view name, void* value, const JsonKind& kind) const {
  const auto there = find(name);
  return !there || kind.read(*there, value);
}

bool JsonReader::hidden_member(std::string_view name, void* value, const JsonKind& kind) const {
  const auto there = find(name);
  return !there || (there->is_shown() && kind.read(*there, value));
}

bool JsonReader::is_shown() const {
  return !(data_->is_string() && text_of(*data_) == hidden) ||
         fail(
             "the text stands for a secret that was left out; write the secret itself, or omit the "
             "member");
}

// ---------------------------------------------------------------------------------------------
// Structs

bool JsonMembers::member(std::string_view name, void* value, const JsonKind& kind) {
  if (from_ != nullptr) return from_->member(name, value, kind);
  if (to_ != nullptr) {
    to_->member(name, value, kind);
  } else {
    names_.push_back(name);
  }
  return true;
}

bool JsonMembers::hidden_member(std::string_view name, void* value, const JsonKind& kind) {
  if (from_ != nullptr) return from_->hidden_member(name, value, kind);
  if (to_ != nullptr) {
    to_->hidden_member(name);
  } else {
    names_.push_back(name);
  }
  return true;
}

void write_json_members(JsonWriter to, JsonVisit visit, void* value) {
  to.open_object();
  JsonMembers writing(to);
  static_cast<void>(visit(writing, value));
}

bool read_json_members(const JsonReader& from, JsonVisit visit, void* value) {
  JsonMembers naming;
  static_cast<void>(visit(naming, value));
  JsonMembers reading(from);
  return from.expect_object(naming.names()) && visit(reading, value);
}

// ---------------------------------------------------------------------------------------------
// The parts of the functions in json.hpp that do not depend on the type

namespace json_detail {

std::string text(const void* value, const JsonKind& kind, int indent) {
  nlohmann::ordered_json draft;
  kind.write(JsonWriter(draft), value);
  return draft.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

bool check_depth(const json& data, JsonError& error) {
  if (!deeper_than(data, json_depth)) return true;
  error = {"", "nested deeper than " + std::to_string(json_depth)};
  return false;
}

bool parse(std::string_view text, JsonError& error, bool (*read)(const JsonReader&, void*),
           void* target) {
  json data;
  try {
    if (text.starts_with("\xEF\xBB\xBF")) {
      error = {"", "not JSON: it begins with a byte order mark"};
      return false;
    }
    Once once;
    data = json::parse(text, std::ref(once));
  } catch (const Once::Twice& twice) {
    error = {twice.name, "the member occurs twice"};
    return false;
  } catch (const json::exception& problem) {
    error = {"", std::string("not JSON: ") + problem.what()};
    return false;
  }
  return check_depth(data, error) && read(JsonReader(data, error), target);
}

bool allowed(const std::string& violation, JsonError& error) {
  if (violation.empty()) return true;
  const std::size_t colon = violation.find(": ");
  if (colon == std::string::npos) {
    error = {"", violation};
  } else {
    error = {violation.substr(0, colon), violation.substr(colon + 2)};
  }
  return false;
}

}  // namespace json_detail

}  // namespace gecos::wire
