#pragma once

#include <cstddef>

#include "gecos/base/ids.hpp"
#include "gecos/description.hpp"
#include "gecos/session/protocol/start_words.hpp"

namespace gecos::session {

/// The data of a call that the queue of the called object uses.
struct QueueEntry {
  QueueEntry(SessionId its_client, const OperationDescription& its_operation,
             std::size_t its_bytes = 0)
      : client(its_client), operation(its_operation), bytes(its_bytes) {}
  virtual ~QueueEntry() = default;

  const SessionId client;
  const OperationDescription& operation;
  const std::size_t bytes;  ///< size of the arguments

  CallLane lane = CallLane::None;
  bool of_visitor = false;  ///< the client is a visitor (access/visitors.hpp)
  bool lets_next = false;   ///< the handler has called Execution::let_next
};

}  // namespace gecos::session
