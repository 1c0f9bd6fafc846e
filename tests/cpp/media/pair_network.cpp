#include <algorithm>
#include <cerrno>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "gecos/base/system_error.hpp"
#include "gecos/media/sealed/stream.hpp"
#include "media_under_test.hpp"
#include "pair_medium.hpp"
#include "pair_sockets.hpp"

namespace gecos::media {
namespace {

/// Where each channel of each port is heard.
struct PairTable {
  std::mutex mutex;
  std::map<std::pair<std::uint16_t, std::string>, std::vector<std::weak_ptr<SocketPair>>> heard;
};

class PairPort final : public DatagramPort {
 public:
  PairPort(std::shared_ptr<PairTable> table, std::uint16_t port)
      : table_(std::move(table)), port_(port) {}

  tl::expected<std::uint64_t, MediumError> subscribe(const std::string& channel,
                                                     Take take) override {
    auto sockets = SocketPair::open();
    if (!sockets) return tl::unexpected(MediumError{"pair: " + system_text(errno)});
    sockets_ = std::make_shared<SocketPair>(std::move(*sockets));
    take_ = std::move(take);
    const std::lock_guard lock(table_->mutex);
    table_->heard[{port_, channel}].push_back(sockets_);
    return 1;
  }
  void unsubscribe(std::uint64_t /*subscription*/) override {
    const std::lock_guard lock(mutex_);
    take_ = [](ByteView) {};
  }
  int descriptor() const override { return sockets_ == nullptr ? -1 : sockets_->one.get(); }
  bool pump(int most) override {
    if (sockets_ == nullptr) return false;
    const std::lock_guard lock(mutex_);
    for (int taken = 0; taken < most; ++taken) {
      const auto datagram = receive_datagram(sockets_->one.get(), datagram_);
      if (!datagram) return false;
      take_(*datagram);
    }
    return true;
  }
  /// A datagram that finds no room is lost, as on a network.
  bool publish(const std::string& channel, ByteView datagram) override {
    if (datagram.size() > pair_datagram) return false;
    const std::lock_guard lock(table_->mutex);
    const auto found = table_->heard.find({port_, channel});
    if (found == table_->heard.end()) return true;
    std::erase_if(found->second, [&](const auto& one) {
      const auto sockets = one.lock();
      if (sockets != nullptr) send_datagram(sockets->other.get(), datagram, {});
      return sockets == nullptr;
    });
    return true;
  }

 private:
  const std::shared_ptr<PairTable> table_;
  const std::uint16_t port_;
  std::shared_ptr<SocketPair> sockets_;
  Take take_;
  std::mutex mutex_;  // one receives at a time
  Bytes datagram_;
};

class PairNetwork final : public DatagramNetwork, public std::enable_shared_from_this<PairNetwork> {
 public:
  const Capabilities& capabilities() const override { return sealed_pair_capabilities; }
  const std::string& name() const override { return name_; }
  std::size_t largest_datagram() const override { return pair_datagram; }
  tl::expected<std::unique_ptr<DatagramPort>, MediumError> open(std::uint16_t port) const override {
    return std::make_unique<PairPort>(table_, port);
  }
  tl::expected<std::shared_ptr<DatagramPort>, MediumError> shared(
      std::uint16_t port) const override {
    return std::make_shared<PairPort>(table_, port);
  }
  std::uint16_t draw_reply_port() const override { return draw_port(); }
  std::shared_ptr<const DatagramNetwork> named(const std::string& /*name*/) const override {
    return shared_from_this();
  }

 private:
  const std::string name_ = "here";
  const std::shared_ptr<PairTable> table_ = std::make_shared<PairTable>();
};

}  // namespace

std::shared_ptr<const DatagramNetwork> make_pair_network() {
  return std::make_shared<const PairNetwork>();
}

std::unique_ptr<Medium> make_sealed_pair(const std::string& key_directory) {
  SealedOptions options{.well_known_port = port_of_this_process(), .key_directory = key_directory};
  options.network = make_pair_network();
  return make_sealed(std::move(options));
}

}  // namespace gecos::media
