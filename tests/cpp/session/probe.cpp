#include "probe.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace probe {
namespace {

using gecos::OperationDescription;
using gecos::access::Status;

std::vector<OperationDescription> make_operations() {
  std::vector<OperationDescription> all(9);
  all[0].code = read_code, all[0].name = "read", all[0].status = Status::Sensor;
  all[1].code = move_code, all[1].name = "move", all[1].cancelable = true;
  all[2].code = set_code, all[2].name = "set";
  all[3].code = level_code, all[3].name = "level", all[3].status = Status::Sensor;
  all[4].code = urgent_code, all[4].name = "urgent", all[4].safety = true;
  all[4].status = Status::Sensor;
  all[5].code = finish_code, all[5].name = "finish", all[5].cancelable = true;
  all[5].on_loss = gecos::OnLoss::Finish;
  all[6].code = look_code, all[6].name = "look", all[6].status = Status::Sensor;
  all[6].idempotent = true;
  all[7].code = prompt_code, all[7].name = "prompt", all[7].status = Status::Sensor;
  all[7].quality.start_by = std::chrono::hours(1);
  all[8].code = step_code, all[8].name = "step", all[8].cancelable = true;
  all[8].on_new = gecos::OnNew::Blend;
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.code < b.code; });
  return all;
}

gecos::InterfaceDescription make(std::string_view name) {
  static const auto operations = make_operations();
  static const std::array<std::string_view, 1> bases = {"probe::Device"};
  static const std::array<gecos::StreamDescription, 1> streams = {
      gecos::StreamDescription{level_code, "level", Status::Sensor, 100, 4, {}}};
  static const gecos::InterfaceDescription device{.name = "probe::Device",
                                                  .model = "probe::Device"};
  static const std::array<const gecos::InterfaceDescription*, 2> twice = {&device, &device};
  gecos::InterfaceDescription described;
  described.name = name;
  described.model = name;  // gidl writes JSON; a session does not look into it
  described.inherits = twice;
  described.version = "1.0";
  described.hash = 42;
  described.bases = bases;
  described.operations = operations;
  described.streams = streams;
  return described;
}

bool decode(gecos::wire::Decoder& from, std::int32_t& value) { return from.get(value, "value"); }

gecos::Bytes bytes_of(std::int32_t value) {
  gecos::Bytes bytes(sizeof value);
  gecos::wire::Encoder(bytes).put(value);
  return bytes;
}

}  // namespace

const gecos::InterfaceDescription& description() {
  static const auto described = make("probe::Probe");
  return described;
}

const gecos::InterfaceDescription& other_description() {
  static const auto described = make("probe::Other");
  return described;
}

gecos::OperationDescription operation(gecos::FunctionCode code) {
  const auto* found = description().find(code);
  if (found != nullptr) return *found;
  OperationDescription unknown;
  unknown.code = code;
  unknown.name = "missing";
  unknown.status = Status::Sensor;
  return unknown;
}

gecos::Command<std::int32_t> Probe::number(gecos::FunctionCode code, std::int32_t argument) const {
  return {gecos_session_->call(
              operation(code), sizeof argument, [&](gecos::wire::Encoder& to) { to.put(argument); },
              gecos_options_),
          &decode};
}

tl::expected<gecos::Stream<std::int32_t>, gecos::Failure> Probe::level(
    gecos::StreamAnnotation) const {
  auto core = gecos_session_->subscribe(description().streams[0]);
  if (!core) return tl::unexpected(core.error());
  return gecos::Stream<std::int32_t>(std::move(*core), &decode);
}

void ProbeServant::gecos_dispatch(gecos::IncomingCall call) {
  gecos::wire::Decoder from(call.arguments());
  std::int32_t argument = 0;
  if (!from.get(argument, "argument")) {
    return call.fail({gecos::Detail::BadParameter, from.error().message(), {}, {}});
  }
  const auto code = call.operation().code;
  std::function<void(gecos::IncomingCall)> special;
  {
    const std::lock_guard lock(mutex_);
    if (code == read_code || code == look_code) special = on_read_;
  }
  if (special) return special(std::move(call));
  if (code == step_code) {
    if (argument < 0) {
      note("refuse " + std::to_string(argument));
      return call.fail(gecos::Fault(Jammed{argument}).failure());
    }
    call.let_next();
  }
  if (code == move_code || code == finish_code || code == step_code)
    return move(std::move(call), argument);
  if (code == set_code) {
    if (argument < 0) return call.fail(gecos::Fault(Jammed{argument}).failure());
    note("set " + std::to_string(argument));
    const std::lock_guard lock(mutex_);
    level_ = argument;
  }
  std::int32_t level = 0;
  {
    const std::lock_guard lock(mutex_);
    level = level_;
  }
  call.finish(bytes_of(level));
}

void ProbeServant::move(gecos::IncomingCall call, std::int32_t goal) {
  const std::string which = std::to_string(goal);
  std::function<void()> at_start;
  {
    const std::lock_guard lock(mutex_);
    ++moves_;
    events_.push_back("start " + which);
    at_start = on_move_;
  }
  changed_.notify_all();
  if (at_start) at_start();
  call.progress(0.25, bytes_of(goal));
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (open_) break;
    }
    if (call.wait_interrupted_until(gecos::deadline_after(std::chrono::milliseconds(1)))) {
      note("interrupted " + which);
      return call.fail(gecos::Fault::interrupted().failure());
    }
  }
  note("end " + which);
  call.finish(bytes_of(goal));
}

void ProbeServant::publish(std::int32_t value, std::int64_t stamp_ns) {
  gecos_publish(
      description().streams[0], sizeof value, [value](gecos::wire::Encoder& to) { to.put(value); },
      stamp_ns);
}

void ProbeServant::publish_damaged() {
  gecos_publisher_.with([](gecos::session::Publisher& publisher) {
    publisher.publish(description().streams[0], gecos::Bytes(3), gecos::measured_now);
  });
}

void ProbeServant::on_read(std::function<void(gecos::IncomingCall)> handler) {
  const std::lock_guard lock(mutex_);
  on_read_ = std::move(handler);
}

void ProbeServant::on_move(std::function<void()> at_start) {
  const std::lock_guard lock(mutex_);
  on_move_ = std::move(at_start);
}

void ProbeServant::await(const std::string& what, const std::function<bool()>& come) {
  std::unique_lock lock(mutex_);
  if (changed_.wait_for(lock, std::chrono::seconds(30), come)) return;
  std::string text = what + " did not come; what came:";
  for (const auto& event : events_) text += " '" + event + "'";
  throw std::runtime_error(text);
}

void ProbeServant::await_moves(int count) {
  await("the start of move " + std::to_string(count), [&] { return moves_ >= count; });
}

void ProbeServant::open_gate() {
  const std::lock_guard lock(mutex_);
  open_ = true;
}

void ProbeServant::close_gate() {
  const std::lock_guard lock(mutex_);
  open_ = false;
}

void ProbeServant::note(const std::string& event) {
  {
    const std::lock_guard lock(mutex_);
    events_.push_back(event);
  }
  changed_.notify_all();
}

std::vector<std::string> ProbeServant::events() const {
  const std::lock_guard lock(mutex_);
  return events_;
}

void ProbeServant::await_event(const std::string& event) {
  await("'" + event + "'", [&] { return std::count(events_.begin(), events_.end(), event) > 0; });
}

}  // namespace probe
