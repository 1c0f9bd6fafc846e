#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "gecos/base/function_ref.hpp"
#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/wire/encoder.hpp"

/// The client's side of inward streams.
namespace gecos {

/// The type of `gecos::writer`, an argument that opens an inward stream. Example:
/// `robot.alter(gecos::writer)`. Only attributes with the annotation @stream(dir="in") accept this
/// argument. For any other attribute, the error of the C++ compiler contains the name of this type.
struct InwardStreamAnnotation {};
inline constexpr InwardStreamAnnotation writer{};

namespace session {

/// An opened inward stream without the type of its samples.
class WriterCore {
 public:
  virtual ~WriterCore() = default;  ///< ends the stream
  /// Sends a sample of `size` bytes that `encode` writes. Never waits. `stamp_ns`: the Unix time in
  /// ns at which the sample was measured, or `measured_now`.
  virtual tl::expected<void, Failure> send(std::size_t size,
                                           FunctionRef<void(wire::Encoder&)> encode,
                                           std::int64_t stamp_ns) = 0;
  /// From now on, each sample feeds the command `id`. If `id` is nullopt, the samples feed no
  /// command.
  virtual void feeds(std::optional<CommandId> id) = 0;
  virtual Command<FeedReport> report() = 0;
  virtual bool lost() const = 0;
};

/// Returns the failure of a sample whose value must not be sent. `why` is the text of the failure.
inline tl::unexpected<Failure> refused_sample(std::string why) {
  return tl::unexpected(Failure{Detail::BadParameter, std::move(why), {}, {}});
}

}  // namespace session

/// Sends samples to an object on one inward stream. One thread at a time may send. The stream ends
/// when the last copy of its writer is destroyed. A session has one writer for each stream: opening
/// another writer replaces the earlier one.
///
/// The server judges each sample when the servant reads it, and counts the samples that have no
/// effect. `report()` asks for these counts. Sending never waits for the server and allocates
/// nothing for samples of a fixed size.
template <class T>
class Writer {
 public:
  using Send = tl::expected<void, Failure> (*)(session::WriterCore&, const T&, std::int64_t);
  Writer(std::shared_ptr<session::WriterCore> core, Send encode)
      : core_(std::move(core)), send_(encode) {}

  /// Sends one sample under the session's present status. Fails without sending when the value is
  /// out of its @range or too large, when the session has no status but the stream needs one, and
  /// when the session is lost. `stamp_ns`: the Unix time in ns at which the value was measured.
  [[nodiscard]] tl::expected<void, Failure> send(const T& value,
                                                 std::int64_t stamp_ns = measured_now) {
    return send_(*core_, value, stamp_ns);
  }
  /// From now on, each sample feeds `command`, so that a sample has an effect only while this
  /// command runs and takes samples.
  template <class Result, class Feedback>
  void feeds(const Command<Result, Feedback>& command) {
    core_->feeds(command.id());
  }
  /// From now on, samples feed no command.
  void feeds_no_command() { core_->feeds(std::nullopt); }
  /// Asks the server what became of the samples that this session has sent.
  Command<FeedReport> report() { return core_->report(); }
  /// Returns true when the server is gone or has closed the session, or when the Lab was closed.
  bool lost() const { return core_->lost(); }

 private:
  std::shared_ptr<session::WriterCore> core_;
  Send send_;
};

}  // namespace gecos
