#include "gecos/media/buffers/bulk.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace gecos::media {
namespace {

constexpr std::size_t page = 4096;
constexpr int most_looks = 16;  // calls of look_(): enough to empty a full socket

std::size_t whole_pages(std::size_t bytes) { return (bytes + page - 1) / page * page; }

/// Makes the kernel back the pages with memory now, and returns false when there is not enough
/// memory. Without this call, a lack of memory would kill this process at the first access to a
/// page. The call is also faster than one page fault for each page. Linux before version 5.14 does
/// not support the call; there, the function returns true, and each page is still backed at its
/// first access.
bool bring(const std::byte* at, std::size_t bytes, int how) {
  int done = 0;
  do {
    done = ::madvise(const_cast<std::byte*>(at), bytes, how);
  } while (done != 0 && errno == EINTR);
  return done == 0 || errno == EINVAL;
}

/// Reads `into.size()` bytes of a memfd from the offset `from` on.
bool read_whole(int memfd, std::size_t from, std::span<std::byte> into) {
  while (!into.empty()) {
    const auto got = ::pread(memfd, into.data(), into.size(), static_cast<off_t>(from));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    from += static_cast<std::size_t>(got);
    into = into.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

}  // namespace

tl::expected<std::uint64_t, SendProblem> BulkWriter::write(ByteView head, ByteView body) {
  const std::size_t size = head.size() + body.size();
  if (size > largest_bulk_packet) return tl::unexpected(SendProblem::TooLarge);
  const auto room = place(size);
  if (room.empty()) return tl::unexpected(SendProblem::Full);
  if (!head.empty()) std::memcpy(room.data(), head.data(), head.size());
  if (!body.empty()) std::memcpy(room.data() + head.size(), body.data(), body.size());
  return send_placed();
}

std::span<std::byte> BulkWriter::place(std::size_t size) {
  if (size == 0 || size > largest_bulk_packet || !ring_.has_room()) return {};
  const MutexLock lock(mutex_);
  if (placed_) held_.erase(held_.begin() + static_cast<std::ptrdiff_t>(*placed_));
  placed_.reset();
  if (!area_) {
    area_ = maker_.make_area(number_ + 1);
    if (!area_) return {};
    ++number_;
    backed_ = 0;
  }
  quiet_beats_ = 0;
  if (!find_room(whole_pages(size))) return {};
  placed_size_ = size;
  return {area_->data() + held_[*placed_].offset, size};
}

bool BulkWriter::find_room(std::size_t bytes) {
  std::erase_if(held_,
                [taken = ring_.slots_taken()](const Held& held) { return held.until <= taken; });
  std::size_t offset = 0;
  std::size_t at = 0;
  while (at < held_.size() && held_[at].offset - offset < bytes) {
    offset = held_[at].offset + held_[at].bytes;
    ++at;
  }
  if (area_bytes - offset < bytes || !back(offset + bytes)) return false;
  held_.insert(held_.begin() + static_cast<std::ptrdiff_t>(at), {offset, bytes, 0});
  placed_ = at;
  return true;
}

bool BulkWriter::back(std::size_t end) {
  if (end <= backed_) return true;
  if (!bring(area_->data() + backed_, end - backed_, MADV_POPULATE_WRITE)) return false;
  backed_ = end;
  return true;
}

std::uint64_t BulkWriter::send_placed() {
  const MutexLock lock(mutex_);
  Held& held = held_[*placed_];
  placed_.reset();
  last_packet_ = ring_.announce({number_, held.offset, placed_size_});
  held.until = ring_.slots_written();
  return last_packet_;
}

void BulkWriter::beat() {
  const MutexLock lock(mutex_);
  if (!area_ || ++quiet_beats_ <= area_kept) return;
  if (placed_ || ring_.taken() < last_packet_ || !maker_.release(number_)) return;
  area_.reset();
  held_.clear();
}

void BulkWriter::forget() noexcept {
  if (Mapping* const area = area_.get()) area->forget();
}

void BulkReader::know(std::uint64_t number, std::shared_ptr<const Mapping> area) {
  set(number, {std::move(area), nullptr});
}

void BulkReader::know_unmapped(std::uint64_t number, Descriptor memfd) {
  set(number, {nullptr, std::make_shared<Descriptor>(std::move(memfd))});
}

void BulkReader::set(std::uint64_t number, Area area) {
  const MutexLock lock(mutex_);
  number_ = number;
  std::swap(area_, area);  // a reader that still copies from the previous area keeps it alive
}

void BulkReader::end(std::uint64_t number) {
  Area area;
  const MutexLock lock(mutex_);
  if (number != number_) return;
  std::swap(area_, area);
  ended_.store(true, std::memory_order_relaxed);
}

BulkReader::Area BulkReader::find(std::uint64_t number) {
  for (int looks = 0; looks <= most_looks; ++looks) {
    if (looks != 0) look_();
    const MutexLock lock(mutex_);
    if (number == number_ && area_.known()) return area_;
  }
  return {};
}

std::optional<ByteView> BulkReader::copy(const BulkPlace& place) {
  const Area area = find(place.area);
  if (!area.known()) return std::nullopt;
  if (backed_area_ != place.area) backed_area_ = place.area, backed_ = 0;
  if (!is_valid(place, area)) return std::nullopt;
  if (area.mapping != nullptr && !back(place, *area.mapping)) return std::nullopt;
  make_room(place.size);
  if (area.mapping != nullptr) {
    std::memcpy(copy_.get(), area.mapping->data() + place.offset, place.size);
  } else if (!read_whole(area.memfd->get(), place.offset, {copy_.get(), place.size})) {
    return std::nullopt;
  }
  return ByteView(copy_.get(), place.size);
}

bool BulkReader::is_valid(const BulkPlace& place, const Area& area) const {
  if (place.size == 0 || place.size > largest_bulk_packet) return false;
  if (place.offset > area_bytes || place.size > area_bytes - place.offset) return false;
  // A packet begins at the start of the area or directly after an earlier packet. So its offset is
  // at most backed_, which is the end of the packets that were read before.
  return area.mapping == nullptr || place.offset <= backed_;
}

bool BulkReader::back(const BulkPlace& place, const Mapping& area) {
  const std::size_t end = whole_pages(place.offset + place.size);
  if (end <= backed_) return true;
  if (!bring(area.data() + backed_, end - backed_, MADV_POPULATE_READ)) return false;
  backed_ = end;
  return true;
}

void BulkReader::make_room(std::size_t size) {
  if (size <= copy_bytes_) return;
  const std::size_t wanted =
      std::clamp<std::size_t>(2 * copy_bytes_, whole_pages(size), largest_bulk_packet);
  copy_.reset();
  copy_bytes_ = 0;
  copy_ = std::make_unique_for_overwrite<std::byte[]>(wanted);
  copy_bytes_ = wanted;
}

void BulkReader::free_copy() {
  ended_.store(false, std::memory_order_relaxed);
  copy_.reset();
  copy_bytes_ = 0;
}

void BulkReader::forget() noexcept {
  if (area_.mapping != nullptr) const_cast<Mapping&>(*area_.mapping).forget();
  if (area_.memfd != nullptr) area_.memfd->reset();
}

}  // namespace gecos::media
