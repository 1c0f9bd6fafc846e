#pragma once

#include "gecos/media/descriptor.hpp"

namespace gecos::media {

/// An eventfd that its owner sleeps on and others ring.
class Bell {
 public:
  /// Throws std::system_error when the process has no descriptor left.
  Bell();
  int descriptor() const { return fd_.get(); }
  /// Makes the descriptor unreadable again. True when the bell had been rung. Never blocks,
  /// whatever flags somebody else who holds the descriptor has set on it.
  bool quiet();
  void close() { fd_.reset(); }

 private:
  Descriptor fd_;
};

/// Rings the bell behind `descriptor`.
void ring_bell(int descriptor);

}  // namespace gecos::media
