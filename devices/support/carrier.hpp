// Computes the positions of devices that are mounted on a moving carrier, such as the flange of an
// arm.
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

/// The carrier of a device: the flange of a manipulator, or the fixed world. The last sample of the
/// flange's stream gives the position of a flange. Any thread may call `frame`; only one thread may
/// call `tick`.
class Carrier {
 public:
  /// The frame of a flange counts as unknown when its stream has had no sample for this time.
  static constexpr gecos::Duration patience = std::chrono::seconds(1);

  explicit Carrier(gecos::Lab& lab) : lab_(lab) {}

  /// From now on, the carrier is the flange of the object `name`, or the world if `name` is empty.
  /// The object need not be online yet.
  void follow(const std::string& name);
  std::string name() const;

  /// Connects or reconnects to the flange's stream when needed. Must be called regularly, on a
  /// thread that may block: a call takes up to 0.2 s while the object is not online, and up to one
  /// second more to open the stream.
  void tick();

  /// Returns the frame of the carrier in the world, or the reason why the frame is unknown.
  tl::expected<robcl::Frame, std::string> frame();

 private:
  std::shared_ptr<FlangeStream> flange() const;

  gecos::Lab& lab_;
  mutable gecos::Mutex guard_;                                     // never held while connecting
  std::shared_ptr<FlangeStream> flange_ GECOS_GUARDED_BY(guard_);  // null: the world is the carrier
};

/// Says where the base of a device is: at a fixed frame, seen from the device's carrier.
class Mounting {
 public:
  Mounting(gecos::Lab& lab, const std::string& carrier, const robcl::Frame& carrier_from_base);

  Carrier& carrier() { return carrier_; }
  std::string parent() const { return carrier_.name(); }
  /// Returns the frame of the base in the world, or the reason why the frame is unknown.
  gecos::Result<robcl::Frame> base();
  /// Mounts the device on the flange of the arm `carrier`, or in the world if `carrier` is empty.
  /// First connects to the arm and opens the stream of its flange. If that is impossible, fails
  /// with robcl::MountRefused and changes nothing. Does not wait for a sample of the stream.
  gecos::Result<void> mount(const std::string& carrier, const robcl::Frame& carrier_from_base);

 private:
  gecos::Lab& lab_;
  Carrier carrier_;
  mutable gecos::Mutex guard_;
  robcl::Frame carrier_from_base_ GECOS_GUARDED_BY(guard_);
};

}  // namespace devices
