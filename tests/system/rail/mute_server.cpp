// Serves RAIL. When it has read a line it is mute: it gives signs of life, takes what its clients
// send, and sends them nothing.

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <utility>

#include "gecos/binding.hpp"
#include "gecos/gecos.hpp"
#include "gecos/media/layers/layer.hpp"
#include "rail.hpp"

namespace {

using gecos::media::Role;

std::atomic<bool> mute{false};

class MuteConnection final : public gecos::media::ConnectionLayer {
 public:
  using ConnectionLayer::ConnectionLayer;
  tl::expected<std::uint64_t, gecos::media::SendProblem> send(gecos::ByteView head,
                                                              gecos::ByteView body) override {
    ++sent_;
    if (mute) return sent_;
    if (auto sent = ConnectionLayer::send(head, body); !sent) {
      --sent_;
      return sent;
    }
    return sent_;
  }

 private:
  std::uint64_t sent_ = 0;  ///< also what was lost
};

std::unique_ptr<gecos::media::Medium> wrap(std::unique_ptr<gecos::media::Medium> inner) {
  const gecos::media::Capabilities layer_capabilities = inner->capabilities();
  return gecos::media::make_layer(std::move(inner), layer_capabilities,
                                  [](std::unique_ptr<gecos::media::Connection> connection,
                                     const gecos::media::Capabilities& capabilities,
                                     Role role) -> std::unique_ptr<gecos::media::Connection> {
                                    if (role == Role::Client) return connection;  // to the broker
                                    return std::make_unique<MuteConnection>(std::move(connection),
                                                                            capabilities);
                                  });
}

}  // namespace

int main() {
  gecos::Lab lab = gecos::session::LabAccess::with_media({}, wrap);
  Rail rail;
  gecos::Server server(lab);  // ends before what it serves
  const auto added = server.add("RAIL", rail, {.simulated = true, .thread_safe = true});
  if (!added) {
    std::fprintf(stderr, "%s\n", added.error().text.c_str());
    return 1;
  }
  std::puts("serving RAIL");
  std::fflush(stdout);
  std::string line;
  std::getline(std::cin, line);
  mute = true;
  std::puts("mute");
  std::fflush(stdout);
  server.run();
}
