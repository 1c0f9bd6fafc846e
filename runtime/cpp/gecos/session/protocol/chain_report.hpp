#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gecos/wire/decoder.hpp"
#include "gecos/wire/encoder.hpp"

namespace gecos::session {

/// What a client reports to the server together with an actor command: what the program knew about
/// earlier commands of the session when the program issued this command. The body of a Call packet
/// with the flags `reports` begins with a ChainReport.
struct ChainReport {
  enum class Known : std::uint8_t {
    Failure = 1,   ///< the program has seen that the command did not succeed
    Canceled = 2,  ///< the program has canceled the command before it saw how the command ended
    Detached = 3,  ///< the outcome of the command does not matter to the program
  };
  struct Entry {
    std::uint64_t counter = 0;
    Known known{};
    friend bool operator==(const Entry&, const Entry&) = default;
  };
  /// The largest number of entries in a packet. If there are more, the next command reports the
  /// remaining ones.
  static constexpr std::size_t most = 255;

  std::vector<Entry> entries;

  std::size_t encoded_size() const { return 4 + entries.size() * entry_size; }
  void encode(wire::Encoder& to) const {
    to.put_count(entries.size());
    for (const Entry& entry : entries) {
      to.put(entry.counter, static_cast<std::uint8_t>(entry.known));
    }
  }
  /// Ignores entries of a kind that this version does not know.
  [[nodiscard]] bool decode(wire::Decoder& from) {
    std::size_t count = 0;
    if (!from.get_count(count, entry_size, most, "chain report")) return false;
    for (; count > 0; --count) {
      std::uint64_t counter = 0;
      std::uint8_t known = 0;
      if (!from.get(counter, "counter") || !from.get(known, "known")) return false;
      if (known >= 1 && known <= 3) entries.push_back({counter, static_cast<Known>(known)});
    }
    return true;
  }

 private:
  static constexpr std::size_t entry_size = 8 + 1;
};

}  // namespace gecos::session
