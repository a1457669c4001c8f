// What PhysicalStorageBuffer pointers may reach: the allocations that were made for device addresses. A device address is the
// host's.
//
// Threads: allocating and freeing change the table while queues execute, so executors hold a snapshot. What is freed while a
// shader may use it is the application's error.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "base/abi.h"

namespace pineda::icd {

class AddressTable {
 public:
  using Snapshot = std::shared_ptr<const std::vector<AddressRange>>;

  void add(uint64_t address, uint64_t size_bytes);
  void remove(uint64_t address);

  // Changes with the table: a snapshot of this version is up to date.
  uint64_t version() const { return version_.load(std::memory_order_acquire); }
  Snapshot snapshot() const;

 private:
  struct Allocation {
    uint64_t address, size_bytes;
  };
  void publish();  // with mutex_ held

  mutable std::mutex mutex_;
  std::vector<Allocation> allocations_;  // by address
  Snapshot ranges_ = std::make_shared<const std::vector<AddressRange>>();
  std::atomic<uint64_t> version_{0};
};

}  // namespace pineda::icd
