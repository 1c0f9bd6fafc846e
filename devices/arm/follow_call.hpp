// Connects a running handler of `follow` to the arm.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "devices/arm/arm_device.hpp"
#include "devices/arm/latest.hpp"
#include "gecos/servant.hpp"
#include "robcl/manipulator_types.hpp"

namespace devices {

/// Gives the samples of the inward stream `alter` to the control loop, as corrections.
class StreamCorrections final : public robcl::motion::CorrectionSource {
 public:
  using Stream = gecos::Inward<Frame>;

  explicit StreamCorrections(Stream& stream) : stream_(&stream) {}

  std::optional<Frame> next() override;
  bool expired() override;
  void report(const robcl::motion::FollowState& state) override { state_.write(state); }

  robcl::motion::FollowState state() const { return state_.read(); }
  /// Must be called before the stream is destroyed. Afterwards, `next` returns no corrections.
  void close() { stream_.store(nullptr); }

 private:
  std::atomic<Stream*> stream_;
  Latest<robcl::motion::FollowState> state_{{}};
};

/// A MotionWatcher for the handler of `follow`. Also makes the reply of the handler.
class FollowCall final : public MotionWatcher {
 public:
  using Progress = gecos::Execution<robcl::FollowState>;

  FollowCall(Progress& run, StreamCorrections::Stream& stream);
  ~FollowCall() override { corrections_->close(); }
  FollowCall(const FollowCall&) = delete;
  FollowCall& operator=(const FollowCall&) = delete;

  std::shared_ptr<StreamCorrections> corrections() const { return corrections_; }
  bool interrupted() override;
  void progress(double fraction, double remaining) override;
  /// Returns the reply to the call of `follow`. `ended` is the outcome of the motion.
  gecos::Result<void> answer(const tl::expected<void, MoveFailure>& ended) const;

 private:
  Progress& run_;
  StreamCorrections::Stream& stream_;
  const StreamCorrections::Stream::Feeding feeding_;
  const std::shared_ptr<StreamCorrections> corrections_;
  const std::uint64_t unreadable_before_;
  std::optional<std::string> unreadable_;  // why a sample is no correction
};

robcl::motion::FollowLimits limits_of(const robcl::FollowLimits& asked);

}  // namespace devices
