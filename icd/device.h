// VkDevice: owns the queues, the thread pool and what all objects share. Creating one starts no thread and loads no compiler.
//
// Loss is sticky: the first reason, with the place in the driver that found it, is reported; from then on submissions and waits
// return VK_ERROR_DEVICE_LOST. Everything else keeps working, so that an application can clean up.
#pragma once

#include <array>
#include <atomic>
#include <mutex>
#include <source_location>
#include <string>
#include <unordered_map>

#include "compiler/sample_functions.h"
#include "icd/address_table.h"
#include "icd/background.h"
#include "icd/dispatch.h"
#include "icd/notifier.h"
#include "icd/object.h"
#include "icd/physical_device.h"
#include "icd/scheduler.h"
#include "icd/texture_state.h"
#include "icd/unbound_set.h"
#include "icd/watchdog.h"
#include "raster/thread_pool.h"

namespace pineda::icd {

class Device : public Dispatchable, public Object {
 public:
  Device(const Allocator& from, PhysicalDevice& owner, const GateSet& gates);

  PhysicalDevice& physical;
  Notifier notifier;  // fences, events, queries
  TextureStates texture_states;
  compiler::SampleFunctions sample_functions;
  AddressTable addresses;
  UnboundSet unbound_set;
  Background background;       // better kernels than those in use
  Background code_generation;  // the kernels of new pipelines
  raster::ThreadPool pool;     // used by whoever holds the scheduler's baton

  Watchdog watchdog;
  std::array<Queue, kQueueFamilyCount> queues;
  Scheduler scheduler;  // last: its worker uses the others

  // Whether the extension of a command is enabled, on the device or on its instance.
  bool has(Gate gate) const;

  bool lost() const { return lost_.load(std::memory_order_acquire); }
  void lose(std::string_view reason, std::source_location where = std::source_location::current());
  // What lose() has reported; empty before.
  std::string loss_reason() const;

  // vkWait*: VK_TIMEOUT when ready() does not hold in time. Who has no deadline executes what is pending rather than sleep beside
  // it.
  template <typename Ready>
  VkResult wait(uint64_t timeout_ns, Ready&& ready) {
    while (timeout_ns == Notifier::kForever && !ready() && scheduler.help()) {
    }
    const auto over = [&] { return ready() || lost(); };
    const bool in_time = over() || (timeout_ns != 0 && notifier.wait(deadline_after(timeout_ns), over));
    if (lost()) return VK_ERROR_DEVICE_LOST;
    return in_time ? VK_SUCCESS : VK_TIMEOUT;
  }

  // Accounts for device memory; false when the heap has no room.
  bool reserve_memory(VkDeviceSize size_bytes);
  void return_memory(VkDeviceSize size_bytes) {
    memory_bytes_.fetch_sub(size_bytes);
    count_device_memory(-int64_t(size_bytes));
  }

  // Names given by the application, by handle; empty when there is none.
  void set_name(uint64_t handle, std::string_view name);
  std::string name_of(uint64_t handle) const;
  void forget_name(uint64_t handle);

 private:
  const GateSet gates_;  // of the enabled device extensions
  std::atomic<bool> lost_{false};
  mutable std::mutex loss_mutex_;  // guards loss_reason_
  std::string loss_reason_;
  std::atomic<VkDeviceSize> memory_bytes_{0};
  mutable std::mutex names_mutex_;  // guards names_
  std::unordered_map<uint64_t, std::string> names_;
  std::atomic<bool> any_name_{false};  // most applications name nothing: no lock on destruction then
};

// vkCreate* of objects that belong to a device: constructs T(allocator, device, info) after T::check(device, info).
template <typename T, typename Info, typename Handle>
VkResult create_device_object(VkDevice device, const Info* info, const VkAllocationCallbacks* callbacks, Handle* out) {
  return guarded([&] {
    *out = VK_NULL_HANDLE;
    Device& owner = *from(device);
    if constexpr (requires { T::check(owner, *info); }) {
      if (const VkResult result = T::check(owner, *info); result != VK_SUCCESS) return result;
    }
    *out = to_handle(
        make_object<T>(Allocator(callbacks, owner.allocator), VK_SYSTEM_ALLOCATION_SCOPE_OBJECT, owner, *info).release());
    return VK_SUCCESS;
  });
}

template <typename Handle>
void destroy_device_object(VkDevice device, Handle handle, const VkAllocationCallbacks* callbacks) {
  if (!handle) return;
  from(device)->forget_name(reinterpret_cast<uint64_t>(handle));
  destroy_object(from(handle), callbacks, from(device)->allocator);
}

}  // namespace pineda::icd
