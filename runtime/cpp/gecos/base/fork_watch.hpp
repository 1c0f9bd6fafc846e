#pragma once

namespace gecos {

/// Notifies its owner in a forked child that the descriptors and the memory of the owner belong to
/// the parent.
///
/// A child shares the sockets and rings of its parent. If the child used them, it would corrupt the
/// parent's packets. If the child only kept them open, the parent's peers could not notice the
/// death of the parent. A ForkWatch must be the last member of its owner.
class ForkWatch {
 public:
  using Abandon = void (*)(void* owner) noexcept;
  /// `abandon` runs in the only thread of the child, inside fork(). It may close descriptors and
  /// unmap memory, but must not allocate memory or take a lock.
  ForkWatch(void* owner, Abandon abandon);
  ~ForkWatch();
  ForkWatch(const ForkWatch&) = delete;
  ForkWatch& operator=(const ForkWatch&) = delete;

 private:
  friend struct ForkList;
  void* owner_;
  Abandon abandon_;
  // The neighbours of this watch in the list of all watches. The mutex of the list guards them.
  ForkWatch* previous_ = nullptr;
  ForkWatch* next_ = nullptr;
};

}  // namespace gecos
