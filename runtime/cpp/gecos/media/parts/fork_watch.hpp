#pragma once

namespace gecos::media {

/// Notifies its owner, in a forked child, that the owner's descriptors and memory belong to the
/// parent.
///
/// A child shares the parent's sockets and rings: using them would corrupt the parent's packets,
/// and merely holding them hides the parent's death from the parent's peers. A ForkWatch must be
/// its owner's last member.
class ForkWatch {
 public:
  using Abandon = void (*)(void* owner) noexcept;
  /// `abandon` runs in the child's only thread inside fork(): it may close and unmap, but must not
  /// allocate or take a lock.
  ForkWatch(void* owner, Abandon abandon);
  ~ForkWatch();
  ForkWatch(const ForkWatch&) = delete;
  ForkWatch& operator=(const ForkWatch&) = delete;

 private:
  friend struct ForkList;
  void* owner_;
  Abandon abandon_;
  // The list of all watches, guarded by its mutex.
  ForkWatch* previous_ = nullptr;
  ForkWatch* next_ = nullptr;
};

}  // namespace gecos::media
