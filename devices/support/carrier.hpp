// Where devices are that stand on something that moves.
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

/// The flange of a manipulator, as its stream last said; or the world, which stands. Any thread may
/// ask; one thread calls `tick`.
class Carrier {
 public:
  /// A flange that was silent for longer than this is not known any more.
  static constexpr gecos::Duration patience = std::chrono::seconds(1);

  explicit Carrier(gecos::Lab& lab) : lab_(lab) {}

  /// Follows the flange of `name` from now on; empty: the world. It need not be there yet.
  void follow(const std::string& name);
  std::string name() const;

  /// Connects, or connects again, when that is needed; call it now and then, where waiting for up
  /// to 0.2 s does no harm.
  void tick();

  /// The flange in the world; or why it is not known.
  tl::expected<robcl::Frame, std::string> frame();

 private:
  std::shared_ptr<FlangeStream> flange() const;

  gecos::Lab& lab_;
  mutable gecos::Mutex guard_;                                     // never held while connecting
  std::shared_ptr<FlangeStream> flange_ GECOS_GUARDED_BY(guard_);  // null: the world
};

/// A device's base: fixed to a carrier.
class Mounting {
 public:
  Mounting(gecos::Lab& lab, const std::string& carrier, const robcl::Frame& carrier_from_base);

  Carrier& carrier() { return carrier_; }
  std::string parent() const { return carrier_.name(); }
  /// The frame in the world; fails with the reason why it is not known.
  gecos::Result<robcl::Frame> base();
  /// Waits until the new carrier is heard. Fails with robcl::MountRefused when it is not, and then
  /// changes nothing.
  gecos::Result<void> mount(const std::string& carrier, const robcl::Frame& carrier_from_base);

 private:
  gecos::Lab& lab_;
  Carrier carrier_;
  mutable gecos::Mutex guard_;
  robcl::Frame carrier_from_base_ GECOS_GUARDED_BY(guard_);
};

}  // namespace devices
