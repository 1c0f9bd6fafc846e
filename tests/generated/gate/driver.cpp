// What the gate's programs do alike, and what stands in for the session below generated proxies.
#include "driver.hpp"

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "gecos/media/medium.hpp"

namespace gate {

gecos::ByteView In::take(std::size_t size) {
  if (size > rest_.size()) std::abort();  // the gate and the program do not mean the same type
  const auto taken = rest_.first(size);
  rest_ = rest_.subspan(size);
  return taken;
}

Answer yes(gecos::Bytes bytes) { return {true, std::move(bytes)}; }

Answer no(std::string_view why) {
  const auto bytes = std::as_bytes(std::span(why));
  return {false, {bytes.begin(), bytes.end()}};
}

gecos::Progress Done::progress() const {
  return {failure_ ? failure_->detail : gecos::Detail::Done, 0, 1};
}

std::shared_ptr<gecos::session::CommandCore> Line::call(
    const gecos::OperationDescription&, std::size_t size,
    gecos::FunctionRef<void(gecos::wire::Encoder&)> encode, const gecos::CallOptions&) {
  gecos::Bytes bytes(size);
  gecos::wire::Encoder to(bytes);
  encode(to);
  bytes.resize(to.written());
  request = std::move(bytes);
  return std::make_shared<Done>(reply_);
}

tl::expected<std::shared_ptr<gecos::session::StreamCore>, gecos::Failure> Line::subscribe(
    const gecos::StreamDescription&) {
  return tl::unexpected(gecos::Failure{});
}

tl::expected<std::shared_ptr<gecos::session::WriterCore>, gecos::Failure> Line::open_writer(
    const gecos::InwardDescription&) {
  return tl::unexpected(gecos::Failure{});
}

const gecos::media::Capabilities& Line::capabilities() const {
  static const gecos::media::Capabilities none;
  return none;
}

int run(std::span<const Question> questions, int count, char** words) {
  if (count != 3) return 2;
  std::ifstream from(words[1], std::ios::binary);
  const std::string all{std::istreambuf_iterator<char>(from), {}};
  std::ofstream to(words[2], std::ios::binary);
  In in(std::as_bytes(std::span(all)));
  for (auto left = in.number<std::uint32_t>(); left > 0; --left) {
    const auto which = in.number<std::uint32_t>();
    const auto first = in.take(in.number<std::uint32_t>());
    const auto second = in.take(in.number<std::uint32_t>());
    const Answers answers = questions[which](first, second);
    for (const Answer& each : {answers.first, answers.second}) {
      const auto size = static_cast<std::uint32_t>(each.bytes.size());
      to.put(each.fine ? '\1' : '\0');
      to.write(reinterpret_cast<const char*>(&size), sizeof size);
      to.write(reinterpret_cast<const char*>(each.bytes.data()), size);
    }
    to.flush();
  }
  return 0;
}

}  // namespace gate

namespace gecos::session {

std::shared_ptr<CommandCore> ended(Failure failure) {
  return std::make_shared<gate::Done>(std::move(failure));
}

Refused::Refused(std::string why, ClientSession& session, const OperationDescription& operation)
    : core_(session.refuse(operation, {Detail::BadParameter, std::move(why), {}, {}})) {}

Refused::Refused(std::string why)
    : core_(ended(Failure{Detail::BadParameter, std::move(why), {}, {}})) {}

const std::shared_ptr<ClientSession>& nil_session() {
  static const std::shared_ptr<ClientSession> nil = std::make_shared<gate::Line>(ByteView{});
  return nil;
}

}  // namespace gecos::session
