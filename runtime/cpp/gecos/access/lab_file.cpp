#include "gecos/access/lab_file.hpp"

#define TOML_EXCEPTIONS 0
// Switches off the assertions of toml++. A malformed text such as "[#allow]" would fail an
// assertion and end the program; without assertions, toml++ reports the error.
#define TOML_ASSERT(condition) static_assert(true)
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace gecos::access {
namespace {

using Keys = std::span<const std::string_view>;

constexpr std::array<std::string_view, 9> known_tables = {
    "admin", "allow", "broker", "clock", "media", "names", "objects", "programs", "streams"};
constexpr std::array<std::string_view, 1> streams_keys = {"open"};
constexpr std::array<std::string_view, 2> broker_keys = {"address", "start"};
constexpr std::array<std::string_view, 1> clock_keys = {"speed"};
constexpr std::array<std::string_view, 1> medium_keys = {"real_time"};
constexpr std::array<std::string_view, 4> program_keys = {"environment", "ready", "restart", "run"};
constexpr std::array<std::string_view, 3> object_keys = {"allow", "sources", "zone"};
constexpr std::array<std::string_view, 2> allow_keys = {"hosts", "users"};

/// Returns how many letters must be added, removed or replaced to turn `one` into `two`.
std::size_t edits_between(std::string_view one, std::string_view two) {
  std::vector<std::size_t> row(two.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= one.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= two.size(); ++j) {
      const std::size_t replaced = diagonal + (one[i - 1] == two[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, replaced}));
    }
  }
  return row.back();
}

std::string instead_of(std::string_view key, Keys known) {
  std::string all;
  for (const std::string_view one : known) {
    if (edits_between(key, one) <= std::max<std::size_t>(1, one.size() / 3)) {
      return "did you mean " + std::string(one) + "?";
    }
    all += (all.empty() ? "" : ", ") + std::string(one);
  }
  return "known keys are " + all;
}

std::size_t line_of(const toml::source_region& region) {
  return std::max<std::size_t>(region.begin.line, 1);
}

/// Reads the tree of a lab file. Throws a LabFileError, which parse_lab_file() catches.
class LabFileReader {
 public:
  explicit LabFileReader(const std::string& file) : file_(file) {}

  LabAccess read(const toml::table& root, MediaNames media_names) const {
    LabAccess lab{.file = file_};
    // These two are called only because they throw the errors in their tables.
    broker(root);
    media(root, media_names);
    if (const auto* clock = find(root, "clock", "clock")) {
      admit_only(*clock, "clock.", clock_keys);
    }
    for_each_table(root, "programs", [&](const auto&, const auto& table, const auto& place) {
      admit_only(table, place + ".", program_keys);
    });
    if (const auto* admin = find(root, "admin", "admin")) lab.admin = list_of(*admin, "admin");
    if (const auto* allow = find(root, "allow", "allow")) lab.general = list_of(*allow, "allow");
    for_each_table(root, "objects", [&](const auto& name, const auto& table, const auto& place) {
      read_object(lab, name, table, place);
    });
    if (const auto* names = find(root, "names", "names")) {
      for (const auto& [name, owner] : *names) {
        if (name.str() == broker_object) {
          refuse(
              name.source(), "names.BROKER",
              "the broker is not registered under a name, so this line has no effect; remove it: "
              "each client decides by key or user which brokers it trusts");
        }
        lab.names.emplace(name.str(), owner_of(name, owner, "names"));
      }
    }
    if (const auto* streams = find(root, "streams", "streams")) {
      lab.forbids_open_streams = forbids_open(*streams);
    }
    return lab;
  }

  LabBroker broker(const toml::table& root) const {
    admit_only(root, "", known_tables);  // an unknown table may be a misspelt [broker]
    const auto* const table = find(root, "broker", "broker");
    if (table == nullptr) return {};
    admit_only(*table, "broker.", broker_keys);
    const toml::node* const start = flag(*table, "start", "broker.start");
    const toml::node* const address = table->get("address");
    if (address == nullptr) return {};
    if (address->value_or(std::string()).empty()) {
      refuse(address->source(), "broker.address",
             "the address of a broker is expected, for example address = \"lcm\"");
    }
    if (start != nullptr && start->value_or(false)) {
      refuse(
          address->source(), "broker.address",
          "this address names a broker that runs already, but `start = true` starts one; leave out "
          "`address` or `start`");
    }
    return {address->ref<std::string>(),
            "[broker] in " + file_ + ":" + std::to_string(line_of(address->source()))};
  }

  LabMedia media(const toml::table& root, MediaNames names) const {
    admit_only(root, "", known_tables);  // an unknown table may be a misspelt [media]
    if (const auto* const all = find(root, "media", "media")) admit_only(*all, "media.", names);
    LabMedia stated;
    for_each_table(root, "media", [&](const auto& name, const auto& table, const auto& place) {
      admit_only(table, place + ".", medium_keys);
      const toml::node* const real_time = flag(table, "real_time", place + ".real_time");
      if (real_time == nullptr) {
        refuse(table.source(), place,
               "this table is empty; write real_time = true or real_time = false");
      }
      stated.emplace(name, LabMedium{real_time->value_or(false),
                                     "[" + place + "] in " + file_ + ":" +
                                         std::to_string(line_of(real_time->source()))});
    });
    return stated;
  }

 private:
  [[noreturn]] void refuse(const toml::source_region& where, std::string key,
                           std::string why) const {
    throw LabFileError{file_, line_of(where), std::move(key), std::move(why)};
  }

  void admit_only(const toml::table& table, const std::string& prefix, Keys known) const {
    for (const auto& [key, value] : table) {
      if (std::ranges::find(known, key.str()) != known.end()) continue;
      refuse(key.source(), prefix + std::string(key.str()),
             "this key is unknown; " + instead_of(key.str(), known));
    }
  }

  const toml::table* find(const toml::table& table, std::string_view key,
                          const std::string& place) const {
    const toml::node* const value = table.get(key);
    if (value == nullptr) return nullptr;
    if (!value->is_table()) refuse(value->source(), place, "a table is expected");
    return value->as_table();
  }

  const toml::node* flag(const toml::table& table, std::string_view key,
                         const std::string& place) const {
    const toml::node* const value = table.get(key);
    if (value != nullptr && !value->is_boolean()) {
      refuse(value->source(), place, "true or false is expected");
    }
    return value;
  }

  std::string forbids_open(const toml::table& streams) const {
    admit_only(streams, "streams.", streams_keys);
    const toml::node* const open = flag(streams, "open", "streams.open");
    if (open == nullptr || open->value_or(true)) return "";
    return "[streams] in " + file_ + ":" + std::to_string(line_of(open->source()));
  }

  template <class Visit>
  void for_each_table(const toml::table& root, const std::string& within, Visit visit) const {
    const auto* const all = find(root, within, within);
    if (all == nullptr) return;
    for (const auto& [key, value] : *all) {
      const std::string name(key.str());
      const std::string place = within + "." + name;
      visit(name, *find(*all, name, place), place);
    }
  }

  void read_object(LabAccess& lab, const std::string& name, const toml::table& table,
                   const std::string& place) const {
    admit_only(table, place + ".", object_keys);
    if (table.empty()) {
      refuse(table.source(), place,
             "this table is empty; write users = […] below [" + place + ".allow], or zone = \"…\"");
    }
    const auto* const allow = find(table, "allow", place + ".allow");
    if (allow != nullptr) lab.objects.emplace(name, list_of(*allow, place + ".allow"));
    if (const auto* const sources = find(table, "sources", place + ".sources")) {
      for (const auto& [source, owner] : *sources) {
        lab.sources[name].emplace(source.str(), owner_of(source, owner, place + ".sources"));
      }
    }
    if (const toml::node* const zone = table.get("zone")) {
      lab.zones.emplace(name, zone_of(name, *zone, place + ".zone"));
    }
  }

  std::string zone_of(const std::string& object, const toml::node& value,
                      const std::string& place) const {
    std::string zone = value.value_or(std::string());
    if (zone.empty()) {
      refuse(value.source(), place, "the name of a zone is expected, for example zone = \"CELL\"");
    }
    if (zone == object || object == broker_object) {
      refuse(value.source(), place,
             zone == object ? "a zone cannot be in itself; remove this line"
                            : "the broker moves nothing, so it needs no zone; remove this line");
    }
    return zone;
  }

  AllowList list_of(const toml::table& table, const std::string& place) const {
    admit_only(table, place + ".", allow_keys);
    if (table.empty()) {
      refuse(table.source(), place,
             "this table is empty; write users = [] if only the user of the server may connect");
    }
    return {names_of(table, place, "users"), names_of(table, place, "hosts"),
            "[" + place + "] in " + file_ + ":" + std::to_string(line_of(table.source()))};
  }

  NameOwner owner_of(const toml::key& key, const toml::node& value,
                     const std::string& within) const {
    const std::string name(key.str());
    const std::string text = value.value_or(std::string());
    const std::size_t at = text.find('@');
    if (at == 0 || at >= text.size() - 1 || text.find('@', at + 1) != std::string::npos ||
        text.find(everyone) != std::string::npos) {
      refuse(value.source(), within + "." + name,
             "a user and a host are expected, for example " + name + " = \"robcl@cell\"");
    }
    return {{text.substr(0, at), text.substr(at + 1)},
            "[" + within + "] in " + file_ + ":" + std::to_string(line_of(key.source()))};
  }

  std::vector<std::string> names_of(const toml::table& table, const std::string& of,
                                    std::string_view key) const {
    const toml::node* const value = table.get(key);
    if (value == nullptr) return {};
    const std::string place = of + "." + std::string(key);
    const std::string wanted =
        "a list of names is expected, for example " + std::string(key) + " = [\"anna\"]";
    if (!value->is_array()) refuse(value->source(), place, wanted);
    std::vector<std::string> names;
    for (const toml::node& element : *value->as_array()) {
      if (!element.is_string()) refuse(element.source(), place, wanted);
      names.push_back(element.ref<std::string>());
      const auto fault = fault_of_name(names.back());
      if (!fault.empty()) {
        refuse(element.source(), place, "a name " + std::string(fault) + "; " + wanted);
      }
    }
    if (names.size() > 1 && std::ranges::find(names, everyone) != names.end()) {
      refuse(
          value->source(), place,
          "\"*\" admits all names, so the other names have no effect; remove \"*\" or the others");
    }
    return names;
  }

  const std::string& file_;
};

/// Parses the text of a lab file. Returns the result of `read` for the parsed tree, or the error in
/// the text.
template <class Read>
auto parse(const std::string& text, const std::string& file, Read read)
    -> tl::expected<decltype(read(LabFileReader(file), toml::table())), LabFileError> {
  const toml::parse_result parsed = toml::parse(text, file);
  if (!parsed) {
    const toml::parse_error& error = parsed.error();
    return tl::unexpected(LabFileError{file, error.source().begin.line, "",
                                       "this is not TOML: " + std::string(error.description())});
  }
  try {
    return read(LabFileReader(file), parsed.table());
  } catch (LabFileError& error) {
    return tl::unexpected(std::move(error));
  }
}

}  // namespace

std::string to_string(const LabFileError& error) {
  std::string text = error.file + ":";
  if (error.line != 0) text += std::to_string(error.line) + ":";
  text += " ";
  if (!error.key.empty()) text += error.key + ": ";
  return text + error.text;
}

tl::expected<LabAccess, LabFileError> parse_lab_file(const std::string& text,
                                                     const std::string& file, MediaNames media) {
  return parse(text, file, [&](const auto& reader, const toml::table& root) {
    return reader.read(root, media);
  });
}

tl::expected<LabBroker, LabFileError> parse_lab_broker(const std::string& text,
                                                       const std::string& file) {
  return parse(text, file,
               [](const auto& reader, const toml::table& root) { return reader.broker(root); });
}

tl::expected<LabMedia, LabFileError> parse_lab_media(const std::string& text,
                                                     const std::string& file, MediaNames media) {
  return parse(text, file, [&](const auto& reader, const toml::table& root) {
    return reader.media(root, media);
  });
}

EditedLabFile::EditedLabFile(std::string file, MediaNames media)
    : lists_{.file = std::move(file)}, media_(media) {}

std::optional<LabFileError> EditedLabFile::take(const Text& now) {
  std::string text = now ? *now : to_string(now.error());
  if (taken_ == text && readable_ == now.has_value()) return std::nullopt;
  taken_ = std::move(text);
  readable_ = now.has_value();
  error_.reset();
  auto lists =
      now.and_then([&](const std::string& it) { return parse_lab_file(it, lists_.file, media_); });
  if (!lists) return error_ = std::move(lists.error());
  lists_ = *std::move(lists);
  known_ = true;
  return std::nullopt;
}

}  // namespace gecos::access
