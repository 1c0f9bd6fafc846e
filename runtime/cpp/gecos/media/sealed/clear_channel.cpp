#include "gecos/media/sealed/clear_channel.hpp"

#include <utility>

namespace gecos::media {
namespace {

constexpr std::size_t longest_channel_name = 63;  // of LCM

class ClearChannel final : public OpenChannel {
 public:
  ClearChannel(std::shared_ptr<DatagramPort> port, std::string name, std::size_t largest)
      : port_(std::move(port)), name_(std::move(name)), largest_(largest) {}

  tl::expected<void, SendProblem> publish(ByteView message) override {
    if (message.size() > largest_) return tl::unexpected(SendProblem::TooLarge);
    port_->publish(name_, message);
    return {};
  }

 private:
  const std::shared_ptr<DatagramPort> port_;
  const std::string name_;
  const std::size_t largest_;
};

}  // namespace

tl::expected<std::unique_ptr<OpenChannel>, MediumError> open_clear_channel(
    const SealedOptions& options, const std::string& name) {
  if (options.open_port == 0) return nullptr;
  if (name.size() > longest_channel_name) {
    return tl::unexpected(MediumError{"the name of the channel, " + name + ", has " +
                                      std::to_string(name.size()) + " bytes; at most " +
                                      std::to_string(longest_channel_name) +
                                      " are possible: give the object a shorter name"});
  }
  auto port = options.network->shared(options.open_port);
  if (!port) return tl::unexpected(std::move(port.error()));
  return std::make_unique<ClearChannel>(std::move(*port), name,
                                        options.network->largest_datagram());
}

}  // namespace gecos::media
