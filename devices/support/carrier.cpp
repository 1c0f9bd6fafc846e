#include "devices/support/carrier.hpp"

#include <chrono>
#include <utility>

namespace devices {
namespace {

using namespace std::chrono_literals;

std::shared_ptr<FlangeStream> flange_of(gecos::Lab& lab, const std::string& name,
                                        gecos::Duration patience) {
  gecos::ReconnectOptions options;
  options.create.patience = patience;
  options.silence = Carrier::patience;
  const auto open = [](const robcl::Manipulator& arm) { return arm.flange(gecos::stream); };
  return std::make_shared<FlangeStream>(lab, name, open, options);
}

}  // namespace

void Carrier::follow(const std::string& name) {
  const gecos::MutexLock lock(guard_);
  if (name == (flange_ ? flange_->name() : std::string())) return;
  flange_ = name.empty() ? nullptr : flange_of(lab_, name, 200ms);
}

std::shared_ptr<FlangeStream> Carrier::flange() const {
  const gecos::MutexLock lock(guard_);
  return flange_;
}

std::string Carrier::name() const {
  const auto flange = this->flange();
  return flange ? flange->name() : std::string();
}

void Carrier::tick() {
  if (const auto flange = this->flange()) flange->tick();
}

tl::expected<robcl::Frame, std::string> Carrier::frame() {
  const auto flange = this->flange();
  if (!flange) return robcl::Frame();
  const auto sample = flange->latest();
  if (sample) return sample->value;
  return tl::unexpected("the position of the flange of '" + flange->name() +
                        "' is unknown: " + sample.error());
}

Mounting::Mounting(gecos::Lab& lab, const std::string& carrier,
                   const robcl::Frame& carrier_from_base)
    : lab_(lab), carrier_(lab), carrier_from_base_(carrier_from_base) {
  carrier_.follow(carrier);
}

gecos::Result<robcl::Frame> Mounting::base() {
  const auto carrier = carrier_.frame();
  if (!carrier) return tl::unexpected(gecos::Fault::failed(carrier.error()));
  const gecos::MutexLock lock(guard_);
  return *carrier * carrier_from_base_;
}

gecos::Result<void> Mounting::mount(const std::string& carrier,
                                    const robcl::Frame& carrier_from_base) {
  if (!carrier.empty()) {
    const auto flange = flange_of(lab_, carrier, 500ms);
    flange->tick();
    if (!flange->proxy()) {
      return tl::unexpected(robcl::MountRefused{flange->latest().error()});
    }
  }
  const gecos::MutexLock lock(guard_);
  carrier_.follow(carrier);
  carrier_from_base_ = carrier_from_base;
  return {};
}

}  // namespace devices
