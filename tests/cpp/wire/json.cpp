#include "json.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace gecos::testing {
namespace {

class Reader {
 public:
  explicit Reader(const std::string& text) : text_(text) {}

  Json whole() {
    Json json = value();
    if (next() != '\0') refuse("something after the end");
    return json;
  }

 private:
  Json value() {
    Json json;
    const char first = next();
    if (first == '{') {
      json.kind = Json::Kind::Object;
      list('}', [&] {
        json.keys.push_back(string());
        expect(':');
        json.items.push_back(value());
      });
    } else if (first == '[') {
      json.kind = Json::Kind::List;
      list(']', [&] { json.items.push_back(value()); });
    } else if (first == '"') {
      json.kind = Json::Kind::String;
      json.text = string();
    } else {
      while (at_ < text_.size() && std::string_view(",]} \n").find(text_[at_]) == std::string::npos)
        json.text.push_back(text_[at_++]);
      json.kind = json.text == "null"                           ? Json::Kind::Null
                  : json.text == "true" || json.text == "false" ? Json::Kind::Boolean
                                                                : Json::Kind::Number;
    }
    return json;
  }

  template <typename Each>
  void list(char close, Each each) {
    ++at_;
    if (next() == close) {
      ++at_;
      return;
    }
    do each();
    while (accept(','));
    expect(close);
  }

  std::string string() {
    expect('"');
    std::string result;
    while (at_ < text_.size() && text_[at_] != '"') {
      const char c = text_[at_++];
      result.push_back(c == '\\' ? escaped() : c);
    }
    expect('"');
    return result;
  }

  // Python writes no others when it may write UTF-8.
  char escaped() {
    constexpr std::string_view names = "\"\\/bfnrt";
    constexpr std::string_view meanings = "\"\\/\b\f\n\r\t";
    const char name = at_ < text_.size() ? text_[at_++] : '\0';
    if (name == 'u') {
      const int code = std::stoi(text_.substr(at_, 4), nullptr, 16);
      if (code > 0x7F) refuse("an escape above 7f");
      at_ += 4;
      return static_cast<char>(code);
    }
    const std::size_t which = names.find(name);
    if (which == std::string_view::npos) refuse("an unknown escape");
    return meanings[which];
  }

  char next() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }

  bool accept(char wanted) {
    if (next() != wanted) return false;
    ++at_;
    return true;
  }

  void expect(char wanted) {
    if (!accept(wanted)) refuse(std::string("no ") + wanted);
  }

  [[noreturn]] void refuse(const std::string& why) {
    throw std::runtime_error("JSON at byte " + std::to_string(at_) + ": " + why);
  }

  const std::string& text_;
  std::size_t at_ = 0;
};

}  // namespace

Json Json::from_text(const std::string& text) { return Reader(text).whole(); }

Json Json::from_vectors(const std::string& name) {
  const std::string path = std::string(GECOS_VECTORS) + "/" + name;
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::ostringstream text;
  text << file.rdbuf();
  return from_text(text.str());
}

bool Json::has(const std::string& key) const {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

const Json& Json::operator[](const std::string& key) const {
  const auto found = std::find(keys.begin(), keys.end(), key);
  if (found == keys.end()) throw std::runtime_error("JSON: no member " + key);
  return items[static_cast<std::size_t>(found - keys.begin())];
}

double Json::number() const { return std::strtod(text.c_str(), nullptr); }
std::int64_t Json::integer() const { return std::strtoll(text.c_str(), nullptr, 10); }
std::uint64_t Json::natural() const { return std::strtoull(text.c_str(), nullptr, 10); }

std::vector<double> Json::numbers() const {
  std::vector<double> result;
  for (const Json& item : items) result.push_back(item.number());
  return result;
}

Bytes Json::bytes() const { return from_hex(text); }

Bytes from_hex(const std::string& digits) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoi(digits.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

std::string to_hex(ByteView bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string result;
  for (const std::byte byte : bytes) {
    result.push_back(digits[static_cast<std::size_t>(byte >> 4)]);
    result.push_back(digits[static_cast<std::size_t>(byte & std::byte{15})]);
  }
  return result;
}

}  // namespace gecos::testing
