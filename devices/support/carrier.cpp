#include "support/carrier.hpp"

#include <chrono>
#include <utility>

namespace devices {
namespace {

using namespace std::chrono_literals;

constexpr gecos::Duration between_tries = 500ms;

gecos::TimePoint now() { return std::chrono::steady_clock::now(); }

struct Connection {
  std::optional<gecos::Stream<robcl::Frame>> flange;
  std::string problem;
};

Connection connect(gecos::Lab& lab, const std::string& name, gecos::Duration patience) {
  gecos::CreateOptions options;
  options.patience = patience;
  auto arm = lab.create<robcl::Manipulator>(name, options);
  if (!arm) return {std::nullopt, arm.error().to_string()};
  auto flange = arm->flange(gecos::stream);
  if (!flange) return {std::nullopt, flange.error().text};
  return {std::move(*flange), {}};
}

}  // namespace

void Carrier::follow(const std::string& name) {
  const std::lock_guard lock(guard_);
  if (name == name_) return;
  name_ = name;
  flange_.reset();
  last_.reset();
  problem_ = "'" + name + "' was not heard yet";
  next_try_ = {};
}

std::string Carrier::name() const {
  const std::lock_guard lock(guard_);
  return name_;
}

bool Carrier::heard() {
  if (!flange_) return false;
  const auto sample = flange_->latest();
  if (!sample) return now() - connected_ < patience;
  if (sample->age > patience) return false;
  last_ = sample->value;
  return true;
}

void Carrier::tend() {
  std::string name;
  {
    const std::lock_guard lock(guard_);
    if (name_.empty() || now() < next_try_ || heard()) return;
    name = name_;
    if (flange_) problem_ = "'" + name + "' is silent";
    flange_.reset();
    last_.reset();
  }
  Connection made = connect(lab_, name, 200ms);
  const std::lock_guard lock(guard_);
  if (name != name_) return;
  next_try_ = now() + between_tries;
  connected_ = now();
  flange_ = std::move(made.flange);
  if (!flange_) problem_ = std::move(made.problem);
}

tl::expected<robcl::Frame, std::string> Carrier::frame() {
  const std::lock_guard lock(guard_);
  if (name_.empty()) return robcl::Frame();
  if (heard() && last_) return *last_;
  return tl::unexpected("where the flange of '" + name_ +
                        "' is, is not known: " + (problem_.empty() ? "it is silent" : problem_));
}

Mounting::Mounting(gecos::Lab& lab, const std::string& carrier,
                   const robcl::Frame& carrier_from_base)
    : lab_(lab), carrier_(lab), carrier_from_base_(carrier_from_base) {
  carrier_.follow(carrier);
}

gecos::Result<robcl::Frame> Mounting::base() {
  const auto carrier = carrier_.frame();
  if (!carrier) return tl::unexpected(gecos::Fault::failed(carrier.error()));
  const std::lock_guard lock(guard_);
  return *carrier * carrier_from_base_;
}

gecos::Result<void> Mounting::mount(const std::string& carrier,
                                    const robcl::Frame& carrier_from_base) {
  if (!carrier.empty()) {
    if (const Connection tried = connect(lab_, carrier, 500ms); !tried.flange) {
      return tl::unexpected(robcl::MountRefused{tried.problem});
    }
  }
  const std::lock_guard lock(guard_);
  carrier_.follow(carrier);
  carrier_from_base_ = carrier_from_base;
  return {};
}

}  // namespace devices
