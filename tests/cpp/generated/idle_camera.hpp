// A camera for tests of samples that are read in place: its attributes are empty.
#pragma once

#include "images/camera_server.hpp"

namespace images {

class IdleCamera : public CameraServant {
 protected:
  gecos::Result<Image> picture() override { return Image{}; }
  gecos::Result<Sweep> scan() override { return Sweep{}; }
  gecos::Result<Frame> still() override { return Frame{}; }
  gecos::Result<Dump> raw() override { return Dump{}; }
  gecos::Result<Stereo> both() override { return Stereo{}; }
};

}  // namespace images
