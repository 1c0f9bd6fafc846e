#include "gecos/media/layers/layer.hpp"

#include <utility>

namespace gecos::media {
namespace {

class AcceptorLayer final : public Acceptor {
 public:
  AcceptorLayer(std::unique_ptr<Acceptor> inner, const Capabilities& capabilities,
                std::shared_ptr<const PutLayer> put)
      : inner_(std::move(inner)), capabilities_(capabilities), put_(std::move(put)) {}

  const Capabilities& capabilities() const override { return capabilities_; }
  const std::string& address() const override { return inner_->address(); }
  void admit_by(AdmitPeer admit) override { inner_->admit_by(std::move(admit)); }
  std::unique_ptr<Connection> accept() override {
    auto connection = inner_->accept();
    if (connection == nullptr) return nullptr;
    return (*put_)(std::move(connection), capabilities_, Role::Server);
  }
  bool short_of_descriptors() const override { return inner_->short_of_descriptors(); }
  std::span<const int> descriptors() const override { return inner_->descriptors(); }
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return inner_->make_stream(largest, depth);
  }
  tl::expected<std::unique_ptr<OpenChannel>, MediumError> open_channel(
      const std::string& name) override {
    return inner_->open_channel(name);
  }

 private:
  const std::unique_ptr<Acceptor> inner_;
  const Capabilities capabilities_;
  const std::shared_ptr<const PutLayer> put_;  ///< an acceptor may outlive the medium
};

class MediumLayer final : public Medium {
 public:
  MediumLayer(std::unique_ptr<Medium> inner, const Capabilities& capabilities, PutLayer put)
      : inner_(std::move(inner)),
        capabilities_(capabilities),
        put_(std::make_shared<const PutLayer>(std::move(put))) {}

  const Capabilities& capabilities() const override { return capabilities_; }
  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    auto acceptor = inner_->listen(name, well_known);
    if (!acceptor) return acceptor;
    return std::make_unique<AcceptorLayer>(std::move(*acceptor), capabilities_, put_);
  }
  tl::expected<std::unique_ptr<Connection>, MediumError> connect(
      std::string_view address) override {
    auto connection = inner_->connect(address);
    if (!connection) return connection;
    return (*put_)(std::move(*connection), capabilities_, Role::Client);
  }
  std::string well_known_address(std::string_view name) const override {
    return inner_->well_known_address(name);
  }
  std::vector<std::string> shared_addresses(std::string_view name) const override {
    return inner_->shared_addresses(name);
  }

 private:
  const std::unique_ptr<Medium> inner_;
  const Capabilities capabilities_;
  const std::shared_ptr<const PutLayer> put_;
};

}  // namespace

std::unique_ptr<Medium> make_layer(std::unique_ptr<Medium> inner, const Capabilities& capabilities,
                                   PutLayer put) {
  return std::make_unique<MediumLayer>(std::move(inner), capabilities, std::move(put));
}

}  // namespace gecos::media
