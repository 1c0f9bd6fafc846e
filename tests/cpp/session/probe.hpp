// A device for tests, written by hand as gidl would write it: what it does is in the hands of the
// test.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "gecos/gecos.hpp"
#include "gecos/object_interface.hpp"

namespace probe {

/// As gidl gives them: FNV-1a of the scoped name.
constexpr gecos::FunctionCode function_code(std::string_view scoped_name) {
  std::uint32_t value = 0x811c9dc5;
  for (const char letter : scoped_name) {
    value = (value ^ static_cast<unsigned char>(letter)) * 0x01000193;
  }
  return gecos::FunctionCode{value};
}

inline constexpr auto read_code = function_code("probe::Probe::read");
inline constexpr auto move_code = function_code("probe::Probe::move");
inline constexpr auto set_code = function_code("probe::Probe::set");
inline constexpr auto level_code = function_code("probe::Probe::level");
inline constexpr auto urgent_code = function_code("probe::Probe::urgent");
inline constexpr auto finish_code = function_code("probe::Probe::finish");
inline constexpr auto look_code = function_code("probe::Probe::look");
/// Must start within an hour (`@qos(start_by="1h")`).
inline constexpr auto prompt_code = function_code("probe::Probe::prompt");
inline constexpr auto step_code = function_code("probe::Probe::step");
inline constexpr auto missing_code = function_code("probe::Probe::missing");

const gecos::InterfaceDescription& description();
/// The same operations under another name, and as a type that is not a Probe.
const gecos::InterfaceDescription& other_description();
gecos::OperationDescription operation(gecos::FunctionCode code);

/// What a handler raises.
struct Jammed {
  std::int32_t axis = 0;
  static constexpr std::string_view type_name() { return "probe::Jammed"; }
  static std::int64_t fingerprint() { return 1; }
  std::size_t encoded_size() const { return 4; }
  void encode(gecos::wire::Encoder& to) const { to.put(axis); }
  bool decode(gecos::wire::Decoder& from) { return from.get(axis, "axis"); }
};

/// Client proxy.
class Probe : public virtual gecos::Object {
 public:
  static const gecos::InterfaceDescription& gecos_description() { return description(); }
  Probe() = default;
  explicit Probe(std::shared_ptr<gecos::session::ClientSession> session)
      : gecos::Object(std::move(session)) {}

  gecos::Command<std::int32_t> read() const { return number(read_code, 0); }
  /// `@idempotent`: sent again when its session is lost.
  gecos::Command<std::int32_t> look(std::int32_t which = 0) const {
    return number(look_code, which);
  }
  gecos::Command<std::int32_t> move(std::int32_t goal) const { return number(move_code, goal); }
  /// `@on_new("blend")`: a move that lets the next step begin beside it. Fails if `goal` is
  /// negative.
  gecos::Command<std::int32_t> step(std::int32_t goal) const { return number(step_code, goal); }
  gecos::Command<std::int32_t> set(std::int32_t value) const { return number(set_code, value); }
  gecos::Command<std::int32_t> urgent() const { return number(urgent_code, 0); }
  /// Goes on when its caller is lost.
  gecos::Command<std::int32_t> finish(std::int32_t goal) const { return number(finish_code, goal); }
  gecos::Command<std::int32_t> missing() const { return number(missing_code, 0); }
  tl::expected<gecos::Stream<std::int32_t>, gecos::Failure> level(gecos::StreamAnnotation) const;

  const std::shared_ptr<gecos::session::ClientSession>& session() const { return gecos_session_; }

 private:
  gecos::Command<std::int32_t> number(gecos::FunctionCode code, std::int32_t argument) const;
};

class Other : public Probe {
 public:
  static const gecos::InterfaceDescription& gecos_description() { return other_description(); }
  using Probe::Probe;
};

/// Server side: `read` gives the level, `set` sets it; `move` and `step` run until the test opens
/// the gate or they are interrupted, and note what happened.
class ProbeServant : public gecos::Servant {
 public:
  const gecos::InterfaceDescription& gecos_interface() const override { return description(); }
  void gecos_dispatch(gecos::IncomingCall call) override;

  void publish(std::int32_t value, std::int64_t stamp_ns = gecos::measured_now);
  /// A sample that is no value of the stream's type.
  void publish_damaged();

  /// Waits until `count` moves have started since the beginning.
  void await_moves(int count);
  /// Lets every move that runs or comes finish.
  void open_gate();
  void close_gate();
  std::vector<std::string> events() const;
  /// Waits until an event like this happened.
  void await_event(const std::string& event);

  /// Instead of answering `read` or `look` with the level.
  void on_read(std::function<void(gecos::IncomingCall)> handler);
  /// At the start of `move`, on its thread.
  void on_move(std::function<void()> at_start);

 private:
  /// Throws, and says what came instead, when it does not come within half a minute.
  void await(const std::string& what, const std::function<bool()>& come);

  void move(gecos::IncomingCall call, std::int32_t goal);
  void note(const std::string& event);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::function<void(gecos::IncomingCall)> on_read_;
  std::function<void()> on_move_;
  std::vector<std::string> events_;
  std::int32_t level_ = 7;
  int moves_ = 0;
  bool open_ = false;
};

}  // namespace probe
