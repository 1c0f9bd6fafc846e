#include "gecos/servant.hpp"

#include <cxxabi.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <map>
#include <optional>
#include <typeinfo>
#include <utility>

#include "gecos/base/per_process.hpp"
#include "gecos/wire/check.hpp"

namespace gecos {
namespace {

/// Returns the demangled name of a type.
std::string readable(const char* mangled) {
  int problem = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(mangled, nullptr, nullptr, &problem), &std::free);
  return problem == 0 ? name.get() : mangled;
}

Failure undeclared(std::string_view operation, const std::string& what, const std::string& text,
                   const std::string& advice) {
  return {Detail::Fault,
          "the handler of '" + std::string(operation) + "' " + what +
              ", which it does not declare" + (text.empty() ? "" : ": ") + text + "; " + advice,
          {},
          {}};
}

/// Calls `use` with the bytes that `encode` writes. The bytes lie on the stack, or on the heap when
/// `size` exceeds `usual`.
template <std::size_t usual, class Use>
void with_encoded(std::size_t size, FunctionRef<void(wire::Encoder&)> encode, Use use) {
  std::byte buffer[usual];
  Bytes large;
  std::span<std::byte> bytes(buffer, std::min(size, usual));
  if (size > usual) {
    large.resize(size);
    bytes = large;
  }
  wire::Encoder to(bytes);
  encode(to);
  use(ByteView(bytes.data(), to.written()));
}

/// Logs the samples of this process that are not published, because their values are out of range
/// or too large. A loop may try a thousand of them in a second, so that each stream has at most
/// ten lines of the log in a second. Thread-safe.
class UnpublishedSamples {
 public:
  void log(std::string_view stream, const std::string& why) {
    if (const auto line = line_for(stream, why)) log_error(stream, *line);
  }

 private:
  /// Returns the line of the log for a sample; nullopt if the stream has had enough lines.
  std::optional<std::string> line_for(std::string_view stream, const std::string& why) {
    const MutexLock lock(mutex_);
    Lines& lines = streams_[std::string(stream)];
    const TimePoint now(std::chrono::steady_clock::now());
    if (now >= lines.began + std::chrono::seconds(1)) {
      lines.began = now;
      lines.count = 0;
    }
    if (++lines.count > most_lines) {
      ++lines.left_out;
      return std::nullopt;
    }
    std::string line = "not published: " + why;
    if (const auto others = std::exchange(lines.left_out, 0); others != 0) {
      line += "; " + std::to_string(others) +
              " earlier samples were not published either and are not logged";
    }
    return line;
  }

  static constexpr int most_lines = 10;
  struct Lines {
    TimePoint began{};  ///< of the second in which `count` lines were wanted
    int count = 0;
    std::uint64_t left_out = 0;
  };
  Mutex mutex_;
  std::map<std::string, Lines> streams_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace

namespace session {

bool PublisherSlot::claim(std::shared_ptr<Publisher> publisher) {
  const MutexLock lock(mutex_);
  if (!served_as().empty()) return false;
  current_.store(nullptr);
  await_users();
  owned_.swap(publisher);  // the earlier publisher is destroyed without the lock
  current_.store(owned_.get());
  return true;
}

tl::expected<LentMemory, std::string> Publisher::lend(const StreamDescription& stream,
                                                      std::size_t size) {
  return tl::unexpected(std::string(stream.name) +
                        ": this publisher lends no memory for samples, but " +
                        std::to_string(size) + " bytes were requested");
}

bool Publisher::publish_lent(const StreamDescription& /*stream*/, const LentMemory& /*memory*/,
                             std::int64_t /*stamp_ns*/) {
  return false;
}

void Publisher::give_back(const StreamDescription& /*stream*/, const LentMemory& /*memory*/) {}

void PublisherSlot::release() {
  std::shared_ptr<Publisher> dropped;  // destroyed without the lock
  const MutexLock lock(mutex_);
  current_.store(nullptr);
  await_users();
  dropped = std::move(owned_);
}

void PublisherSlot::await_users() const {
  while (const std::uint32_t users = users_.load()) users_.wait(users);
}

void PublisherSlot::with(FunctionRef<void(Publisher&)> use) const {
  struct User {
    std::atomic<std::uint32_t>& users;
    explicit User(std::atomic<std::uint32_t>& counted) : users(counted) { ++users; }
    User(const User&) = delete;
    User& operator=(const User&) = delete;
    ~User() {
      if (--users == 0) users.notify_all();
    }
  };
  const User user(users_);
  if (Publisher* const publisher = current_.load()) use(*publisher);
}

std::string PublisherSlot::served_as() const {
  std::string name;
  with([&](Publisher& publisher) { name = publisher.served_as(); });
  return name;
}

}  // namespace session

void session::with_inward(const Servant& servant, const InwardDescription& inward,
                          FunctionRef<void(InwardCore&)> use) {
  servant.gecos_publisher_.with([&](Publisher& publisher) {
    if (InwardCore* const core = publisher.inward(inward)) use(*core);
  });
}

Servant::~Servant() {
  const std::string name = gecos_served_as();
  if (name.empty()) return;
  log_error(name,
            "the servant of this object is destroyed while a Server serves it, which may crash the "
            "program; "
            "declare the servant before the Server");
}

IncomingCall& IncomingCall::operator=(IncomingCall&& other) noexcept {
  IncomingCall dropped(std::move(*this));
  core_ = std::move(other.core_);
  return *this;
}

IncomingCall::~IncomingCall() {
  if (!core_) return;
  fail({Detail::Fault,
        "the handler of '" + std::string(operation().name) + "' gave no answer",
        {},
        {}});
}

void IncomingCall::fail(const Fault& fault, std::initializer_list<std::string_view> declared) {
  Failure failure = fault.failure();
  if (!failure.exception.empty() &&
      std::ranges::find(declared, failure.exception) == declared.end()) {
    failure = undeclared(operation().name, "raised " + failure.exception, failure.text,
                         "add it to raises(…) of the operation");
  }
  fail(std::move(failure));
}

void IncomingCall::fail_as_thrown() {
  if (!core_) return;
  const std::type_info* const type = abi::__cxa_current_exception_type();
  const std::string threw = "threw " + (type == nullptr ? "something" : readable(type->name()));
  constexpr const char* advice = "the handler must catch the exception and return a gecos::Fault";
  try {
    throw;
  } catch (const std::exception& error) {
    fail(undeclared(operation().name, threw, error.what(), advice));
  } catch (...) {
    fail(undeclared(operation().name, threw, {}, advice));
  }
}

void IncomingCall::finish(std::size_t size, FunctionRef<void(wire::Encoder&)> encode) {
  with_encoded<512>(size, encode, [this](ByteView result) { finish(result); });
}

bool IncomingCall::answer(const Result<void>& result,
                          std::initializer_list<std::string_view> declared) {
  if (result) {
    finish(ByteView{});
  } else {
    fail(result.error(), declared);
  }
  return true;
}

bool IncomingCall::refuse(const wire::DecodeError& why) {
  fail({Detail::BadParameter, why.message(), {}, {}});
  return true;
}

void IncomingCall::fail_result(std::string_view operation, const std::string& why) {
  fail({Detail::Fault, "the handler of " + std::string(operation) + " gave " + why, {}, {}});
}

void Servant::gecos_dispatch(IncomingCall call) {
  try {
    if (gecos_answer(call)) return;
    call.fail({Detail::UnknownOperation,
               std::string(gecos_interface().name) +
                   " has no operation with the code of this call; "
                   "build client and server from one interface",
               {},
               {}});
  } catch (...) {
    call.fail_as_thrown();
  }
}

void Servant::gecos_publish(const StreamDescription& outward, std::size_t size,
                            FunctionRef<void(wire::Encoder&)> encode, std::int64_t stamp_ns) {
  with_encoded<4096>(size, encode, [&](ByteView sample) {
    gecos_publisher_.with(
        [&](session::Publisher& publisher) { publisher.publish(outward, sample, stamp_ns); });
  });
}

tl::expected<Loan, std::string> Servant::gecos_lend(const StreamDescription& outward,
                                                    const LentSize& size,
                                                    FunctionRef<void(wire::Encoder&)> encode) {
  if (size.octets > size.most) {
    return tl::unexpected(wire::over_bound(outward.name, size.octets, size.most, "octets"));
  }
  tl::expected<session::LentMemory, std::string> lent;
  gecos_publisher_.with(
      [&](session::Publisher& publisher) { lent = publisher.lend(outward, size.bytes); });
  if (!lent) return tl::unexpected(std::move(lent.error()));
  if (lent->bytes.empty()) return Loan();
  wire::BulkPlace bulk{size.octets};
  wire::Encoder to(lent->bytes);
  to.leave_bulk(bulk);
  encode(to);
  const bool complete = to.written() == size.bytes;
  Loan loan(gecos_publisher_, outward, *std::move(lent), bulk.octets);
  if (complete) return loan;
  return tl::unexpected(std::string(outward.name) +
                        ": the @bulk member of the value has elements; leave it empty and write "
                        "them into the loan");
}

Loan Servant::gecos_lent(std::string_view name, tl::expected<Loan, std::string> lent) {
  if (lent) return *std::move(lent);
  gecos_not_published(name, lent.error());
  return {};
}

void Servant::gecos_not_published(std::string_view name, const std::string& why) {
  static constinit PerProcess<UnpublishedSamples> samples;
  samples.get().log(name, why);
}

std::int64_t unix_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace gecos
