#include "icd/device.h"

#include <algorithm>
#include <cstring>

#include "base/config.h"
#include "base/log.h"
#include "compiler/compile.h"
#include "icd/api.h"
#include "icd/debug_utils.h"
#include "icd/extensions.h"
#include "icd/features.h"
#include "icd/instance.h"

namespace pineda::icd {

Device::Device(const Allocator& from, PhysicalDevice& owner, const GateSet& gates)
    : Object(from),
      physical(owner),
      sample_functions([this](uint32_t view, uint32_t sampler) { return texture_states.combine(view, sampler); }),
      background(1),
      code_generation(render_threads()),
      pool(render_threads()),
      watchdog(*this),
      queues{Queue(*this), Queue(*this), Queue(*this)},
      scheduler(*this),
      gates_(gates) {}

bool Device::has(Gate gate) const {
  return scope_of(gate) == GateScope::kDevice ? gates_.has(gate) : physical.instance.has(gate);
}

void Device::lose(std::string_view reason, std::source_location where) {
  if (lost_.exchange(true)) return;
  std::string_view file = where.file_name();
  file = file.substr(file.rfind('/') + 1);
  const auto [command_buffer, queue] = scheduler.executing();
  const MessageScope scope(*this, VK_OBJECT_TYPE_COMMAND_BUFFER, reinterpret_cast<uint64_t>(command_buffer),
                           command_buffer ? queue : nullptr);
  const std::string about = scope.text();
  std::string message = "device lost at " + std::string(file) + ":" + std::to_string(where.line()) + ": " + std::string(reason) +
                        (about.empty() ? "" : " (" + about + ")");
  report(Severity::kError, message);
  {
    const std::scoped_lock lock(loss_mutex_);
    loss_reason_ = std::move(message);
  }
  notifier.notify();  // waits for results that will not come
}

std::string Device::loss_reason() const {
  const std::scoped_lock lock(loss_mutex_);
  return loss_reason_;
}

bool Device::reserve_memory(VkDeviceSize size_bytes) {
  VkDeviceSize used = memory_bytes_.load();
  do {
    if (size_bytes > memory_heap_bytes() || used > memory_heap_bytes() - size_bytes) return false;
  } while (!memory_bytes_.compare_exchange_weak(used, used + size_bytes));
  count_device_memory(int64_t(size_bytes));
  return true;
}

void Device::set_name(uint64_t handle, std::string_view name) {
  const std::scoped_lock lock(names_mutex_);
  if (name.empty()) {
    names_.erase(handle);
  } else {
    names_[handle] = name;
    any_name_ = true;
  }
}

std::string Device::name_of(uint64_t handle) const {
  if (!any_name_) return {};
  const std::scoped_lock lock(names_mutex_);
  const auto found = names_.find(handle);
  return found == names_.end() ? std::string() : found->second;
}

void Device::forget_name(uint64_t handle) {
  if (!any_name_) return;
  const std::scoped_lock lock(names_mutex_);
  names_.erase(handle);
}

namespace {

void report_check() {
  const compiler::CheckStatistics checked = compiler::check_statistics();
  report(checked.differing_bytes == 0 ? Severity::kInfo : Severity::kError,
         "check: " + std::to_string(checked.calls) + " kernel calls stored " + std::to_string(checked.bytes) +
             " bytes, of which " + std::to_string(checked.differing_bytes) + " differ between machine code and evaluator");
}

VkResult check(const VkDeviceCreateInfo& info) {
  if (info.pEnabledFeatures && !features_available(*info.pEnabledFeatures)) return VK_ERROR_FEATURE_NOT_PRESENT;
  if (!features_available(info.pNext)) return VK_ERROR_FEATURE_NOT_PRESENT;
  for (uint32_t i = 0; i < info.queueCreateInfoCount; ++i) {
    const VkDeviceQueueCreateInfo& queue = info.pQueueCreateInfos[i];
    if (queue.queueFamilyIndex >= kQueueFamilyCount || queue.queueCount > 1) return VK_ERROR_INITIALIZATION_FAILED;
  }
  return VK_SUCCESS;
}

}  // namespace

VkResult api::CreateDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info, const VkAllocationCallbacks* callbacks,
                           VkDevice* out) {
  return guarded([&] {
    *out = VK_NULL_HANDLE;
    if (const VkResult result = check(*info); result != VK_SUCCESS) return result;
    const auto gates = enabled_gates(device_extensions(), info->enabledExtensionCount, info->ppEnabledExtensionNames);
    if (!gates) return VK_ERROR_EXTENSION_NOT_PRESENT;
    PhysicalDevice& device = *from(physical);
    const Allocator allocator(callbacks, device.instance.allocator);
    *out = to_handle(make_object<Device>(allocator, VK_SYSTEM_ALLOCATION_SCOPE_DEVICE, device, *gates).release());
    return VK_SUCCESS;
  });
}

void api::DestroyDevice(VkDevice device, const VkAllocationCallbacks* callbacks) {
  if (device && config().mode == Mode::kCheck) report_check();
  if (device) destroy_object(from(device), callbacks, from(device)->physical.instance.allocator);
}

PFN_vkVoidFunction api::GetDeviceProcAddr(VkDevice device, const char* name) {
  const CommandEntry* entry = find_command(name);
  if (!entry || entry->level != Level::kDevice) return nullptr;
  return from(device)->has(entry->gate) ? entry->function : nullptr;
}

void api::GetDeviceQueue(VkDevice device, uint32_t family, uint32_t index, VkQueue* out) {
  *out = family < kQueueFamilyCount && index == 0 ? to_handle(&from(device)->queues[family]) : VK_NULL_HANDLE;
}

void api::GetDeviceQueue2(VkDevice device, const VkDeviceQueueInfo2* info, VkQueue* out) {
  // Queues are created without flags (there is no protected memory), and only a queue of the same flags is found.
  *out = VK_NULL_HANDLE;
  if (info->flags == 0) GetDeviceQueue(device, info->queueFamilyIndex, info->queueIndex, out);
}

// One physical device: nobody is a peer, but of itself.
void api::GetDeviceGroupPeerMemoryFeatures(VkDevice, uint32_t, uint32_t, uint32_t, VkPeerMemoryFeatureFlags* out) {
  *out = VK_PEER_MEMORY_FEATURE_COPY_SRC_BIT | VK_PEER_MEMORY_FEATURE_COPY_DST_BIT | VK_PEER_MEMORY_FEATURE_GENERIC_SRC_BIT |
         VK_PEER_MEMORY_FEATURE_GENERIC_DST_BIT;
}

// The reason is text; addresses mean nothing to an application, as all memory is the process's own.
VkResult api::GetDeviceFaultInfoEXT(VkDevice device, VkDeviceFaultCountsEXT* counts, VkDeviceFaultInfoEXT* info) {
  return guarded([&] {
    counts->addressInfoCount = counts->vendorInfoCount = 0;
    counts->vendorBinarySize = 0;
    if (!info) return VK_SUCCESS;
    const std::string reason = from(device)->loss_reason();
    const size_t length = std::min(reason.size(), sizeof(info->description) - 1);
    std::memcpy(info->description, reason.data(), length);
    info->description[length] = 0;
    return VK_SUCCESS;
  });
}

VkResult api::DeviceWaitIdle(VkDevice device) {
  return guarded([&] { return from(device)->scheduler.wait_idle(nullptr); });
}

}  // namespace pineda::icd
