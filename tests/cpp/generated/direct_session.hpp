// A session that hands each call to a servant at once: generated clients and servers face to face.
#pragma once

#include <gtest/gtest.h>

#include "gecos/object.hpp"
#include "gecos/servant.hpp"

struct Outcome {
  gecos::Bytes result;
  std::optional<gecos::Failure> failure;
};

class Answered final : public gecos::session::CommandCore {
 public:
  explicit Answered(Outcome outcome) : outcome_(std::move(outcome)) {}
  gecos::CommandId id() const override { return {}; }
  gecos::Progress progress() const override {
    return {outcome_.failure ? outcome_.failure->detail : gecos::Detail::Done, 0, 1};
  }
  gecos::Bytes feedback() const override { return {}; }
  bool wait_until(gecos::TimePoint) override { return true; }
  void cancel() override {}
  gecos::ByteView result() const override { return outcome_.result; }
  const gecos::Failure& failure() const override { return *outcome_.failure; }
  int descriptor() override { return -1; }
  void when_ended(std::function<void()> then) override { then(); }

 private:
  Outcome outcome_;
};

class Arrived final : public gecos::session::CallCore {
 public:
  Arrived(const gecos::OperationDescription& operation, gecos::Bytes arguments, Outcome& outcome)
      : operation_(operation), arguments_(std::move(arguments)), outcome_(outcome) {}
  const gecos::OperationDescription& operation() const override { return operation_; }
  gecos::ByteView arguments() const override { return arguments_; }
  const gecos::Caller& caller() const override { return caller_; }
  bool interrupted() const override { return false; }
  bool wait_interrupted_until(gecos::TimePoint) override { return false; }
  void progress(double, gecos::ByteView) override {}
  void finish(gecos::ByteView result) override {
    outcome_.result.assign(result.begin(), result.end());
  }
  void fail(gecos::Failure failure) override { outcome_.failure = std::move(failure); }

 private:
  gecos::OperationDescription operation_;
  gecos::Bytes arguments_;
  Outcome& outcome_;
  gecos::Caller caller_;
};

/// Hands each call to the servant at once.
class Direct final : public gecos::session::ClientSession {
 public:
  explicit Direct(gecos::Servant& servant) : servant_(servant) {}
  std::shared_ptr<gecos::session::CommandCore> call(
      const gecos::OperationDescription& operation, std::size_t size,
      gecos::FunctionRef<void(gecos::wire::Encoder&)> encode, const gecos::CallOptions&) override {
    gecos::Bytes arguments(size);
    gecos::wire::Encoder to(arguments);
    encode(to);
    EXPECT_EQ(to.written(), size) << operation.name;
    return send(operation, std::move(arguments));
  }
  std::shared_ptr<gecos::session::CommandCore> send(const gecos::OperationDescription& operation,
                                                    gecos::Bytes arguments) {
    ++sent;
    Outcome outcome;
    servant_.gecos_dispatch(
        gecos::IncomingCall(std::make_shared<Arrived>(operation, std::move(arguments), outcome)));
    return std::make_shared<Answered>(std::move(outcome));
  }
  std::shared_ptr<gecos::session::CommandCore> refuse(const gecos::OperationDescription&,
                                                      gecos::Failure failure) override {
    return gecos::session::ended(std::move(failure));
  }
  tl::expected<std::shared_ptr<gecos::session::StreamCore>, gecos::Failure> subscribe(
      const gecos::StreamDescription& stream) override {
    return tl::unexpected(gecos::Failure{gecos::Detail::Denied, std::string(stream.name), {}, {}});
  }
  tl::expected<std::shared_ptr<gecos::session::WriterCore>, gecos::Failure> open_writer(
      const gecos::InwardDescription& stream) override {
    return tl::unexpected(gecos::Failure{gecos::Detail::Denied, std::string(stream.name), {}, {}});
  }
  const std::string& interface_name() const override { return name_; }
  const std::string& object_name() const override { return name_; }
  gecos::ObjectRef reference() const override { return {}; }
  const gecos::media::Capabilities& capabilities() const override { return capabilities_; }
  std::uint64_t lease_acquired(std::uint64_t) override { return 0; }
  void lease_released(std::uint64_t) override {}
  std::uint64_t issued() override { return 0; }

  int sent = 0;

 private:
  gecos::Servant& servant_;
  std::string name_ = "STAGE";
  gecos::media::Capabilities capabilities_;
};
