#pragma once

#include <memory>

#include "gecos/object.hpp"
#include "gecos/stream.hpp"

namespace gecos::session {

class ClientConnection;

/// The client side of a subscription to a stream.
class ClientStream final : public StreamCore {
 public:
  ClientStream(std::shared_ptr<ClientConnection> session, FunctionCode code,
               std::unique_ptr<media::StreamReader> reader);
  ~ClientStream() override;

  bool latest(RawSample& into) override;
  tl::expected<void, StreamEnd> next(RawSample& into, TimePoint deadline) override;
  bool lost() const override;
  Duration age(const RawSample& sample) const override;

 private:
  void finish(RawSample& sample) const;

  const std::shared_ptr<ClientConnection> session_;
  const FunctionCode code_;
  const std::unique_ptr<media::StreamReader> reader_;
};

}  // namespace gecos::session
