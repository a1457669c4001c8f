#include "icd/address_table.h"

#include <algorithm>

namespace pineda::icd {

void AddressTable::add(uint64_t address, uint64_t size_bytes) {
  const std::scoped_lock lock(mutex_);
  allocations_.insert(std::ranges::upper_bound(allocations_, address, {}, &Allocation::address), {address, size_bytes});
  publish();
}

void AddressTable::remove(uint64_t address) {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::lower_bound(allocations_, address, {}, &Allocation::address);
  if (found == allocations_.end() || found->address != address) return;
  allocations_.erase(found);
  publish();
}

// A pointer is looked up by the range that begins last before it, so ranges may overlap: those of a large allocation begin every
// 2 GiB and reach as far as 32 bits do.
void AddressTable::publish() {
  constexpr uint64_t kStep = uint64_t{1} << 31, kMaxRange = 0xFFFFFFFFu;
  std::vector<AddressRange> ranges;
  for (const Allocation& a : allocations_) {
    for (uint64_t at = 0; at < a.size_bytes; at += kStep) {
      ranges.push_back({a.address + at, static_cast<uint32_t>(std::min(a.size_bytes - at, kMaxRange)), 0});
    }
  }
  ranges_ = std::make_shared<const std::vector<AddressRange>>(std::move(ranges));
  version_.fetch_add(1, std::memory_order_release);
}

AddressTable::Snapshot AddressTable::snapshot() const {
  const std::scoped_lock lock(mutex_);
  return ranges_;
}

}  // namespace pineda::icd
