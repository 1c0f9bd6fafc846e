// Images of 1920 x 1080 pixels of three octets. HOW of a program that sends them begins with
// "images". Its server makes an image every 5 ms, whether somebody reads or not; a server that is
// asked for each image makes it at the next of these times. Its client answers one line:
//   images SECONDS -> COUNT READABLE_P50 READABLE_P99 WHOLE_P50 WHOLE_P99 SENDING_P50 (ns)
// READABLE is from just before an image is sent until a reader has a pointer to its octets. WHOLE
// is from before the server obtains memory for it until the reader has read every octet. SENDING is
// what the server takes to send it. An image that was overwritten before it was read is lost and
// not counted; when more than a tenth are lost, the client fails. Both ends are on one host and
// share a clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "speaker.hpp"

namespace peers::images {

inline constexpr std::size_t size = std::size_t{1920} * 1080 * 3;

/// The first octets of an image. Times are CLOCK_MONOTONIC, in ns.
struct Stamps {
  std::uint64_t number = 0;  ///< from 1; the low octet of it is every octet behind the stamps
  std::int64_t begun = 0;    ///< before memory for it was obtained
  std::int64_t sent = 0;     ///< immediately before it was sent
  std::int64_t sending = 0;  ///< how long sending the image before took; 0 if unknown
};
static_assert(sizeof(Stamps) == 32);

/// Makes images, each at its time.
class Camera {
 public:
  /// Waits until the next image is due, and begins it.
  void begin();
  /// Writes the image that was begun into `octets`, `size` of them.
  void write(std::uint8_t* octets);
  /// Writes, and sends by `send`, which is timed.
  template <class Send>
  void write_and_send(std::uint8_t* octets, Send&& send) {
    write(octets);
    const auto before = Clock::now();
    send();
    stamps_.sending = std::chrono::nanoseconds(Clock::now() - before).count();
  }

 private:
  Stamps stamps_;
  Clock::time_point due_ = Clock::now();
};

/// A client that reads images.
class Reader {
 public:
  virtual ~Reader() = default;
  /// Waits for the next image that was not yet read. Its octets stay readable until the next call.
  virtual const std::uint8_t* next() = 0;
  /// Returns whether the octets are still those of the same image. Only a server that waits for no
  /// reader overwrites them.
  virtual bool intact() const { return true; }
};

/// Returns whether the arguments of `main` are about images.
bool wanted(int argc, char** argv);

/// Speaks for `main`, as peers::speak() does of calls.
int speak(int argc, char** argv, const std::function<void(const std::string& how)>& serve,
          const std::function<std::unique_ptr<Reader>(const std::string& how,
                                                      const std::string& address)>& connect);

}  // namespace peers::images
