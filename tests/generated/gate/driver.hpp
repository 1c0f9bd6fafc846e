// What the gate's programs share: values in a neutral form, which can also hold what must not be
// sent; calls and handlers without a server; the loop that answers the gate's questions.
//
// The neutral form (see neutral.py) holds numbers in host order, lists with an u32 count, optionals
// with a byte, unions as tag, index of the arm that is held and its value.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "gecos/object.hpp"
#include "gecos/object_ref_types.hpp"
#include "gecos/servant.hpp"
#include "gecos/wire/contents.hpp"

namespace gate {

class In {
 public:
  explicit In(gecos::ByteView bytes) : rest_(bytes) {}
  template <class T>
  T number() {
    T value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  gecos::ByteView take(std::size_t size);

 private:
  gecos::ByteView rest_;
};

class Out {
 public:
  template <class T>
  void number(T value) {
    put(std::as_bytes(std::span(&value, 1)));
  }
  void put(gecos::ByteView bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  void list(std::size_t size) { number(static_cast<std::uint32_t>(size)); }
  gecos::Bytes taken() { return std::move(bytes_); }

 private:
  gecos::Bytes bytes_;
};

/// Reads and writes values of T. Generated programs specialise it for structs and unions.
template <class T>
struct Form {
  static void fill(In& in, T& value) {
    if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(in.number<std::int64_t>());
    } else if constexpr (std::is_same_v<T, bool>) {
      value = in.number<std::uint8_t>() != 0;
    } else {
      static_assert(std::is_arithmetic_v<T>);
      value = in.number<T>();
    }
  }
  static void dump(Out& out, const T& value) {
    if constexpr (std::is_enum_v<T>) {
      out.number(static_cast<std::int64_t>(value));
    } else {
      static_assert(std::is_arithmetic_v<T>);
      out.number(value);
    }
  }
};

template <class... T>
void fill(In& in, T&... values) {
  (Form<T>::fill(in, values), ...);
}
template <class... T>
void dump(Out& out, const T&... values) {
  (Form<T>::dump(out, values), ...);
}

template <>
struct Form<std::string> {
  static void fill(In& in, std::string& value) {
    const auto text = in.take(in.number<std::uint32_t>());
    value.assign(reinterpret_cast<const char*>(text.data()), text.size());
  }
  static void dump(Out& out, const std::string& value) {
    out.list(value.size());
    out.put(std::as_bytes(std::span(value)));
  }
};

template <class T>
struct Form<std::vector<T>> {
  static void fill(In& in, std::vector<T>& value) {
    const auto size = in.number<std::uint32_t>();
    value.clear();
    for (std::uint32_t i = 0; i < size; ++i) {
      T element{};
      Form<T>::fill(in, element);
      value.push_back(std::move(element));
    }
  }
  static void dump(Out& out, const std::vector<T>& value) {
    out.list(value.size());
    for (const T& element : value) Form<T>::dump(out, element);
  }
};

template <class T, std::size_t size>
struct Form<std::array<T, size>> {
  static void fill(In& in, std::array<T, size>& value) {
    for (T& element : value) Form<T>::fill(in, element);
  }
  static void dump(Out& out, const std::array<T, size>& value) {
    for (const T& element : value) Form<T>::dump(out, element);
  }
};

template <class T>
struct Form<std::optional<T>> {
  static void fill(In& in, std::optional<T>& value) {
    value.reset();
    if (in.number<std::uint8_t>() != 0) Form<T>::fill(in, value.emplace());
  }
  static void dump(Out& out, const std::optional<T>& value) {
    out.number(static_cast<std::uint8_t>(value.has_value()));
    if (value) Form<T>::dump(out, *value);
  }
};

template <class Key, class T, class Order>
struct Form<std::map<Key, T, Order>> {
  static void fill(In& in, std::map<Key, T, Order>& value) {
    const auto size = in.number<std::uint32_t>();
    value.clear();
    for (std::uint32_t i = 0; i < size; ++i) {
      Key key{};
      Form<Key>::fill(in, key);
      Form<T>::fill(in, value[key]);
    }
  }
  static void dump(Out& out, const std::map<Key, T, Order>& value) {
    out.list(value.size());
    for (const auto& [key, element] : value) gate::dump(out, key, element);
  }
};

template <class... T>
struct Form<std::variant<std::monostate, T...>> {
  using Held = std::variant<std::monostate, T...>;

  static void fill(In& in, Held& value) {
    fill(in, value, in.number<std::uint32_t>(), std::index_sequence_for<T...>());
  }
  static void dump(Out& out, const Held& value) {
    out.list(value.index());
    std::visit(
        [&](const auto& arm) {
          using Arm = std::remove_cvref_t<decltype(arm)>;
          if constexpr (!std::is_same_v<Arm, std::monostate>) Form<Arm>::dump(out, arm);
        },
        value);
  }

 private:
  template <std::size_t... index>
  static void fill(In& in, Held& value, std::size_t wanted, std::index_sequence<index...>) {
    value = std::monostate{};
    ((wanted == index + 1 ? gate::fill(in, value.template emplace<index + 1>()) : void()), ...);
  }
};

template <>
struct Form<gecos::ObjectRef> {
  static void fill(In& in, gecos::ObjectRef& value) {
    gate::fill(in, value.name, value.interface_hash, value.boot, value.where);
  }
  static void dump(Out& out, const gecos::ObjectRef& value) {
    gate::dump(out, value.name, value.interface_hash, value.boot, value.where);
  }
};

/// Hand-written classes are given as what they are on the wire.
template <class T>
struct HandWritten {
  static void fill(In& in, T& value) {
    gecos::wire::Decoder from(in.take(in.number<std::uint32_t>()));
    if (!value.decode(from)) std::abort();
  }
  static void dump(Out& out, const T& value) {
    const gecos::Bytes bytes = gecos::wire::to_bytes(value);
    out.list(bytes.size());
    out.put(bytes);
  }
};

/// Two answers: bytes or text, and whether they say yes. The second may be empty.
struct Answer {
  bool fine = false;
  gecos::Bytes bytes;
};
struct Answers {
  Answer first, second;
};
Answer yes(gecos::Bytes bytes);
Answer no(std::string_view why);

// -- types ----------------------------------------------------------------------------------------

template <class T>
Answer sent(const T& value) {
  if constexpr (requires { gecos_violation(value); }) {
    if (const std::string why = gecos_violation(value); !why.empty()) return no(why);
  }
  gecos::Bytes bytes(value.encoded_size());
  gecos::wire::Encoder to(bytes);
  value.encode(to);
  bytes.resize(to.written());
  return yes(std::move(bytes));
}

/// A neutral value, encoded and printed.
template <class T>
Answers send(gecos::ByteView neutral, gecos::ByteView) {
  In in(neutral);
  const auto made = std::make_unique<T>();  // clang 14 crashes at local variables of some types
  T& value = *made;
  Form<T>::fill(in, value);
  std::ostringstream printed;
  printed << value;
  const std::string text = std::move(printed).str();
  const auto bytes = std::as_bytes(std::span(text));
  return {sent(value), yes({bytes.begin(), bytes.end()})};
}

/// Bytes of a value, decoded.
template <class T>
Answers receive(gecos::ByteView bytes, gecos::ByteView) {
  const auto value = gecos::wire::from_bytes<T>(bytes);
  if (!value) return {no(value.error().message()), {}};
  Out out;
  Form<T>::dump(out, *value);
  return {yes(out.taken()), sent(*value)};
}

// -- calls ----------------------------------------------------------------------------------------

class Done final : public gecos::session::CommandCore {
 public:
  explicit Done(gecos::ByteView result) : result_(result) {}
  explicit Done(gecos::Failure failure) : failure_(std::move(failure)) {}
  gecos::CommandId id() const override { return {}; }
  gecos::Progress progress() const override;
  gecos::Bytes feedback() const override { return {}; }
  bool wait_until(gecos::TimePoint) override { return true; }
  void cancel() override {}
  gecos::ByteView result() const override { return result_; }
  const gecos::Failure& failure() const override { return *failure_; }
  int descriptor() override { return -1; }
  void when_ended(std::function<void()> then) override { then(); }

 private:
  gecos::ByteView result_;
  std::optional<gecos::Failure> failure_;
};

/// Keeps what a proxy sends, and answers it with given bytes.
class Line final : public gecos::session::ClientSession {
 public:
  explicit Line(gecos::ByteView reply) : reply_(reply) {}
  std::shared_ptr<gecos::session::CommandCore> call(
      const gecos::OperationDescription& operation, std::size_t size,
      gecos::FunctionRef<void(gecos::wire::Encoder&)> encode,
      const gecos::CallOptions& options) override;
  std::shared_ptr<gecos::session::CommandCore> refuse(const gecos::OperationDescription&,
                                                      gecos::Failure failure) override {
    return gecos::session::ended(std::move(failure));
  }
  tl::expected<std::shared_ptr<gecos::session::StreamCore>, gecos::Failure> subscribe(
      const gecos::StreamDescription& stream) override;
  tl::expected<std::shared_ptr<gecos::session::WriterCore>, gecos::Failure> open_writer(
      const gecos::InwardDescription& stream) override;
  const std::string& interface_name() const override { return name_; }
  const std::string& object_name() const override { return name_; }
  const gecos::media::Capabilities& capabilities() const override;
  gecos::ObjectRef reference() const override { return {}; }
  std::uint64_t lease_acquired(std::uint64_t) override { return 0; }
  void lease_released(std::uint64_t) override {}
  std::uint64_t issued() override { return 0; }

  std::optional<gecos::Bytes> request;

 private:
  gecos::ByteView reply_;
  std::string name_ = "gate";
};

/// Arguments through a proxy: the request that it sends, and what it makes of `reply`.
template <class Proxy, class Owner, class T, class Feedback, class... A>
Answers ask(gecos::Command<T, Feedback> (Owner::*method)(A...) const, gecos::ByteView neutral,
            gecos::ByteView reply) {
  In in(neutral);
  std::tuple<std::decay_t<A>...> arguments{};
  std::apply([&](auto&... each) { fill(in, each...); }, arguments);
  const auto line = std::make_shared<Line>(reply);
  const Proxy proxy(line);
  const auto command = std::apply([&](auto&... a) { return (proxy.*method)(a...); }, arguments);
  const auto result = command.get();
  if (!line->request) return {no(result.error().text), {}};
  Answers answers{yes(*line->request), {}};
  if (!result) {
    answers.second = no(result.error().text);
  } else {
    Out out;
    if constexpr (!std::is_void_v<T>) Form<T>::dump(out, *result);
    answers.second = yes(out.taken());
  }
  return answers;
}

class Incoming final : public gecos::session::CallCore {
 public:
  Incoming(const gecos::OperationDescription& operation, gecos::ByteView arguments)
      : operation_(operation), arguments_(arguments) {}
  const gecos::OperationDescription& operation() const override { return operation_; }
  gecos::ByteView arguments() const override { return arguments_; }
  const gecos::Caller& caller() const override { return caller_; }
  bool interrupted() const override { return false; }
  bool wait_interrupted_until(gecos::TimePoint) override { return false; }
  void progress(double, gecos::ByteView) override {}
  void finish(gecos::ByteView result) override { reply = yes({result.begin(), result.end()}); }
  void fail(gecos::Failure failure) override { reply = no(failure.text); }

  Answer reply;

 private:
  const gecos::OperationDescription& operation_;
  gecos::ByteView arguments_;
  gecos::Caller caller_;
};

/// What every handler of the gate's servants does: keeps its arguments, gives a given result.
struct GateHandler {
  gecos::ByteView neutral_result;
  std::optional<gecos::Bytes> heard;

  template <class T, class... A>
  gecos::Result<T> answer(const A&... arguments) {
    Out out;
    (hear(out, arguments), ...);
    heard = out.taken();
    if constexpr (std::is_void_v<T>) {
      return {};
    } else {
      In in(neutral_result);
      T result{};
      Form<T>::fill(in, result);
      return result;
    }
  }

 private:
  template <class A>
  static void hear(Out& out, const A& argument) {
    Form<A>::dump(out, argument);
  }
  template <class Feedback>
  static void hear(Out&, const gecos::Execution<Feedback>&) {}
};

/// A request through a servant: the arguments that its handler gets, and the reply that it sends.
template <class Servant>
Answers serve(std::uint32_t code, gecos::ByteView request, gecos::ByteView neutral_result) {
  Servant servant;
  servant.gate_handler.neutral_result = neutral_result;
  const auto* operation = servant.gecos_interface().find(gecos::FunctionCode{code});
  if (operation == nullptr) return {no("the servant has no such operation"), {}};
  const auto call = std::make_shared<Incoming>(*operation, request);
  servant.gecos_dispatch(gecos::IncomingCall(call));
  if (!servant.gate_handler.heard) return {call->reply, {}};
  return {yes(*servant.gate_handler.heard), call->reply};
}

struct Samples final : gecos::session::Publisher {
  void publish(const gecos::StreamDescription&, gecos::ByteView sample, std::int64_t) override {
    last = yes({sample.begin(), sample.end()});
  }
  Answer last = no("not published");
};

/// A neutral value through a stream.
template <class Servant, class Owner, class A>
Answers publish(void (Owner::*method)(A, std::int64_t), gecos::ByteView neutral, gecos::ByteView) {
  In in(neutral);
  const auto made = std::make_unique<std::decay_t<A>>();
  auto& value = *made;
  Form<std::decay_t<A>>::fill(in, value);
  Servant servant;
  const auto samples = std::make_shared<Samples>();
  servant.gecos_attach(samples);
  (servant.*method)(value, 0);
  return {samples->last, {}};
}

/// A question that the generated program answers.
using Question = Answers (*)(gecos::ByteView, gecos::ByteView);

/// Reads questions from the file that is named, writes the answers to the other one.
int run(std::span<const Question> questions, int count, char** words);

}  // namespace gate
