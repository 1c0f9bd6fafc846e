// The position of devices that are mounted on a moving carrier.
#pragma once

#include <memory>
#include <string>

#include "gecos/base/mutex.hpp"
#include "gecos/gecos.hpp"
#include "gecos/reconnecting.hpp"
#include "robcl/frames/frame.hpp"
#include "robcl/manipulator_client.hpp"

namespace devices {

using FlangeStream = gecos::ReconnectingStream<robcl::Manipulator, robcl::Frame>;

/// What carries a device: the flange of a manipulator, as the last sample of the flange's stream
/// reported it, or the fixed world. Any thread may call `frame`; one thread calls `tick`.
class Carrier {
 public:
  /// Longest silence of the flange's stream, after which the frame is unknown.
  static constexpr gecos::Duration patience = std::chrono::seconds(1);

  explicit Carrier(gecos::Lab& lab) : lab_(lab) {}

  /// Follows the flange of the object `name` from now on, or the world if `name` is empty. The
  /// object need not be online yet.
  void follow(const std::string& name);
  std::string name() const;

  /// Connects or reconnects when needed. Call it regularly, on a thread that may block for up to
  /// 0.2 s.
  void tick();

  /// The frame of the flange in the world, or the reason why it is unknown.
  tl::expected<robcl::Frame, std::string> frame();

 private:
  std::shared_ptr<FlangeStream> flange() const;

  gecos::Lab& lab_;
  mutable gecos::Mutex guard_;                                     // never held while connecting
  std::shared_ptr<FlangeStream> flange_ GECOS_GUARDED_BY(guard_);  // null: the world is the carrier
};

/// The base of a device, fixed to a carrier.
class Mounting {
 public:
  Mounting(gecos::Lab& lab, const std::string& carrier, const robcl::Frame& carrier_from_base);

  Carrier& carrier() { return carrier_; }
  std::string parent() const { return carrier_.name(); }
  /// The frame of the base in the world, or the reason why it is unknown.
  gecos::Result<robcl::Frame> base();
  /// Waits for the first sample of the new carrier. If none arrives, fails with robcl::MountRefused
  /// and changes nothing.
  gecos::Result<void> mount(const std::string& carrier, const robcl::Frame& carrier_from_base);

 private:
  gecos::Lab& lab_;
  Carrier carrier_;
  mutable gecos::Mutex guard_;
  robcl::Frame carrier_from_base_ GECOS_GUARDED_BY(guard_);
};

}  // namespace devices
