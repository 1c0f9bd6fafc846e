#include "schedules/line.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "gecos/wire/packet.hpp"

namespace gecos::session::schedules {

namespace {

using namespace std::chrono_literals;

}  // namespace

std::uint64_t Dice::next() {
  state_ += 0x9e3779b97f4a7c15;
  std::uint64_t mixed = state_;
  mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9;
  mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111eb;
  return mixed ^ (mixed >> 31);
}

Duration Dice::between(Duration shortest, Duration longest) {
  const double ratio = static_cast<double>(longest.count()) / static_cast<double>(shortest.count());
  const double part = static_cast<double>(below(1 << 20)) / (1 << 20);
  return Duration(
      static_cast<Duration::rep>(static_cast<double>(shortest.count()) * std::pow(ratio, part)));
}

TimePoint ScheduleClock::since_boot() const {
  const TimePoint read = seen_by_server();
  if (after_reading) after_reading();
  return read;
}

/// One end of a line. Each touch of what both see is a point at which the schedule may go on with
/// somebody else.
class LineEnd final : public media::Connection {
 public:
  LineEnd(Line& line, Side side) : line_(line), side_(side) {
    capabilities_.reliable = capabilities_.ordered = capabilities_.shared_words =
        line.way_ != Way::Radio;
    capabilities_.reports_death = capabilities_.reliable;
    capabilities_.name = line.way_ == Way::Radio    ? "lcm"
                         : line.way_ == Way::Memory ? "shm"
                                                    : "inproc";
    capabilities_.largest_packet = 64 * 1024;
  }
  ~LineEnd() override {
    if (me().dead) return;
    me().closed = true;
    if (line_.way_ == Way::Radio) {
      line_.put(side_, Line::Kind::Bye, {});
    } else {
      them().other_closed = true;
    }
  }

  const media::Capabilities& capabilities() const override { return capabilities_; }
  const media::Peer& peer() const override { return peer_; }
  tl::expected<std::uint64_t, media::SendProblem> send(ByteView head, ByteView body) override {
    touch();
    Bytes packet(head.begin(), head.end());
    packet.insert(packet.end(), body.begin(), body.end());
    line_.put(side_, Line::Kind::Packet, std::move(packet));
    return ++me().sent;
  }
  std::optional<ByteView> receive() override {
    touch();
    line_.pump(side_);
    if (me().dead || me().arrived.empty()) return std::nullopt;
    me().current = std::move(me().arrived.front());
    me().arrived.pop_front();
    ++me().taken;
    const auto packet = wire::decode_packet(me().current.packet);
    if (packet && packet->header.kind == wire::PacketKind::Goodbye) {
      me().goodbye = true;
      if (side_ == Side::Server && line_.parting) line_.parting();
    }
    return ByteView(me().current.packet);
  }
  Duration age() override { return line_.clock_.now() - me().current.sent; }
  std::optional<std::uint64_t> taken_by_peer() override {
    if (line_.way_ == Way::Radio) return std::nullopt;
    return them().taken;
  }
  bool prepare_to_sleep() override { return false; }  // nobody sleeps here
  void woke() override {}
  std::span<const int> descriptors() const override { return {}; }

  void write_word(std::size_t index, std::uint64_t value) override {
    touch();
    if (me().dead) return;
    if (side_ == Side::Client && line_.mutant_ == Mutant::WithdrawalForgotten) return;
    if (side_ == Side::Server && line_.mutant_ == Mutant::WithdrawalReadBeforeMark) {
      me().late_mark = {index, value};
      return;
    }
    me().words.at(index) = value;
  }
  std::uint64_t peer_word(std::size_t index) override {
    touch();
    const std::uint64_t value = them().words.at(index);
    touch();
    if (me().late_mark) me().words.at(me().late_mark->first) = me().late_mark->second;
    me().late_mark.reset();
    return value;
  }

  void beat() override {
    touch();
    line_.put(side_, Line::Kind::Beat, {});
  }
  std::uint64_t beats_seen() override {
    line_.pump(side_);
    return me().beats;
  }
  media::Loss loss() override {
    line_.pump(side_);
    if (line_.way_ == Way::Memory && them().dead) return media::Loss::Died;
    return me().other_closed ? media::Loss::Closed : media::Loss::None;
  }
  std::string loss_text() const override { return {}; }
  std::unique_ptr<media::StreamWriter> make_stream(std::size_t, std::size_t) override {
    return nullptr;
  }
  tl::expected<void, media::SendProblem> share(std::uint32_t, media::StreamWriter&) override {
    return {};
  }
  void unshare(std::uint32_t) override {}
  std::unique_ptr<media::StreamReader> open_stream(std::uint32_t,
                                                   const media::StreamBounds&) override {
    return nullptr;
  }

 private:
  Line::End& me() { return line_.ends_[Line::index(side_)]; }
  Line::End& them() { return line_.ends_[Line::index(other(side_))]; }
  void touch() {
    if (line_.touched) line_.touched(side_);
  }

  Line& line_;
  const Side side_;
  media::Capabilities capabilities_;
  media::Peer peer_;
};

Line::Line(Way way, Mutant mutant, ScheduleClock& clock, Dice& dice)
    : way_(way), mutant_(mutant), clock_(clock), dice_(dice) {}

std::unique_ptr<media::Connection> Line::connection(Side side) {
  return std::make_unique<LineEnd>(*this, side);
}

void Line::put(Side from, Kind kind, Bytes packet) {
  if (dead(from)) return;
  End& to = ends_[index(other(from))];
  const TimePoint now = clock_.now();
  if (way_ != Way::Radio) {
    if (kind == Kind::Beat) {
      ++to.beats;
    } else {
      to.coming.push_back({kind, std::move(packet), now, now});
    }
    return;
  }
  if (now < cut_until_ || dice_.one_in(10)) return;
  const bool late = dice_.one_in(16);
  const Duration takes = late ? dice_.between(10ms, 2s) : dice_.between(20us, 2ms);
  to.coming.push_back({kind, std::move(packet), now, now + takes});
}

void Line::pump(Side at) {
  End& here = ends_[index(at)];
  if (here.dead) return;
  const TimePoint now = clock_.now();
  const auto here_now = [&](const Frame& frame) { return frame.arrives <= now; };
  for (auto next = std::ranges::find_if(here.coming, here_now); next != here.coming.end();
       next = std::ranges::find_if(here.coming, here_now)) {
    Frame frame = std::move(*next);
    here.coming.erase(next);
    if (way_ == Way::Radio && now - frame.sent < oldest_sign_of_life) ++here.beats;
    if (frame.kind == Kind::Bye) here.other_closed = true;
    if (frame.kind == Kind::Packet) here.arrived.push_back(std::move(frame));
  }
}

}  // namespace gecos::session::schedules
