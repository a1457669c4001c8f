#include "icd/debug_utils.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "icd/api.h"
#include "icd/device.h"
#include "icd/instance.h"

namespace pineda::icd {
namespace {

struct Registry {
  std::mutex mutex;  // guards both lists; nothing is called under it
  std::vector<DebugMessenger*> messengers;
  std::vector<DebugReportCallback*> callbacks;
};

Registry& registry() {
  static Registry instance;
  return instance;
}

void send(const VkDebugUtilsMessengerCreateInfoEXT& to, VkDebugUtilsMessageSeverityFlagBitsEXT severity,
          VkDebugUtilsMessageTypeFlagsEXT types, const VkDebugUtilsMessengerCallbackDataEXT& data) {
  if ((to.messageSeverity & severity) && (to.messageType & types)) to.pfnUserCallback(severity, types, &data, to.pUserData);
}

VkDebugUtilsMessageSeverityFlagBitsEXT severity_bit(Severity severity) {
  switch (severity) {
    case Severity::kInfo:
      return VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT;
    case Severity::kWarning:
      return VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
    case Severity::kError:
      return VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  }
  return VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
}

VkDebugReportFlagsEXT report_flag(Severity severity) {
  switch (severity) {
    case Severity::kInfo:
      return VK_DEBUG_REPORT_INFORMATION_BIT_EXT;
    case Severity::kWarning:
      return VK_DEBUG_REPORT_WARNING_BIT_EXT;
    case Severity::kError:
      break;
  }
  return VK_DEBUG_REPORT_ERROR_BIT_EXT;
}

std::vector<VkDebugReportCallbackCreateInfoEXT> report_listeners(const Instance* of) {
  const std::scoped_lock lock(registry().mutex);
  std::vector<VkDebugReportCallbackCreateInfoEXT> found;
  for (const DebugReportCallback* callback : registry().callbacks) {
    if (!of || &callback->instance == of) found.push_back(callback->info);
  }
  return found;
}

std::vector<VkDebugUtilsMessengerCreateInfoEXT> listeners(const Instance* of) {
  const std::scoped_lock lock(registry().mutex);
  std::vector<VkDebugUtilsMessengerCreateInfoEXT> found;
  for (const DebugMessenger* messenger : registry().messengers) {
    if (!of || &messenger->instance == of) found.push_back(messenger->info);
  }
  return found;
}

thread_local const MessageScope* t_scope = nullptr;

void forward(Severity severity, std::string_view text) {
  const std::string message(text);
  VkDebugUtilsMessengerCallbackDataEXT data{.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT,
                                            .pMessageIdName = "Pineda",
                                            .pMessage = message.c_str()};
  if (t_scope) t_scope->describe(&data);
  for (const auto& listener : listeners(nullptr)) {
    send(listener, severity_bit(severity), VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT, data);
  }
  for (const auto& listener : report_listeners(nullptr)) {
    const VkDebugReportFlagsEXT flag = report_flag(severity);
    if (!(listener.flags & flag)) continue;
    (void)listener.pfnCallback(flag, VK_DEBUG_REPORT_OBJECT_TYPE_UNKNOWN_EXT, 0, 0, 0, "Pineda", message.c_str(),
                               listener.pUserData);
  }
}

void install_sink() {
  static std::once_flag installed;  // for good: without listeners forward() does nothing
  std::call_once(installed, [] { set_log_sink(forward); });
}

void remove_if(auto&& matches) {
  const std::scoped_lock lock(registry().mutex);
  std::erase_if(registry().messengers, matches);
}

}  // namespace

MessageScope::MessageScope(const Device& device, VkObjectType type, uint64_t handle, const Queue* queue)
    : outer_(t_scope), name_(handle ? device.name_of(handle) : std::string()) {
  if (handle)
    objects_.push_back(
        {VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, nullptr, type, handle, name_.empty() ? nullptr : name_.c_str()});
  if (queue) {
    queue_labels_ = queue->labels.snapshot();
    command_labels_ = queue->command_labels();
  }
  t_scope = this;
}

MessageScope::~MessageScope() { t_scope = outer_; }

namespace {

// Innermost first, as the specification wants them.
void add_labels(const std::vector<Label>& from_labels, std::vector<VkDebugUtilsLabelEXT>* out) {
  for (auto label = from_labels.rbegin(); label != from_labels.rend(); ++label) {
    VkDebugUtilsLabelEXT to{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, label->name.c_str(), {}};
    std::ranges::copy(label->color, to.color);
    out->push_back(to);
  }
}

std::string path(const std::vector<Label>& labels) {
  std::string text;
  for (const Label& label : labels) text += (text.empty() ? "" : " > ") + label.name;
  return text;
}

}  // namespace

void MessageScope::describe(VkDebugUtilsMessengerCallbackDataEXT* data) const {
  queue_infos_.clear();
  command_infos_.clear();
  add_labels(queue_labels_, &queue_infos_);
  add_labels(command_labels_, &command_infos_);
  data->objectCount = uint32_t(objects_.size());
  data->pObjects = objects_.data();
  data->queueLabelCount = uint32_t(queue_infos_.size());
  data->pQueueLabels = queue_infos_.data();
  data->cmdBufLabelCount = uint32_t(command_infos_.size());
  data->pCmdBufLabels = command_infos_.data();
}

std::string MessageScope::text() const {
  std::string text = name_.empty() ? "" : "command buffer '" + name_ + "'";
  for (const auto& [what, labels] : {std::pair("label", &command_labels_), std::pair("queue label", &queue_labels_)}) {
    if (!labels->empty()) text += (text.empty() ? "" : ", ") + std::string(what) + " '" + path(*labels) + "'";
  }
  return text;
}

void remove_messengers(const Instance& instance) {
  remove_if([&](const DebugMessenger* messenger) { return &messenger->instance == &instance; });
  const std::scoped_lock lock(registry().mutex);
  std::erase_if(registry().callbacks, [&](const DebugReportCallback* callback) { return &callback->instance == &instance; });
}

VkResult api::CreateDebugUtilsMessengerEXT(VkInstance instance, const VkDebugUtilsMessengerCreateInfoEXT* info,
                                           const VkAllocationCallbacks* callbacks, VkDebugUtilsMessengerEXT* out) {
  return guarded([&] {
    *out = VK_NULL_HANDLE;
    auto messenger = make_object<DebugMessenger>(Allocator(callbacks, from(instance)->allocator),
                                                 VK_SYSTEM_ALLOCATION_SCOPE_OBJECT, *from(instance), *info);
    install_sink();
    const std::scoped_lock lock(registry().mutex);
    registry().messengers.push_back(messenger.get());
    *out = to_handle(messenger.release());
    return VK_SUCCESS;
  });
}

void api::DestroyDebugUtilsMessengerEXT(VkInstance instance, VkDebugUtilsMessengerEXT messenger,
                                        const VkAllocationCallbacks* callbacks) {
  if (!messenger) return;
  remove_if([&](const DebugMessenger* other) { return other == from(messenger); });
  destroy_object(from(messenger), callbacks, from(instance)->allocator);
}

void api::SubmitDebugUtilsMessageEXT(VkInstance instance, VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                     VkDebugUtilsMessageTypeFlagsEXT types, const VkDebugUtilsMessengerCallbackDataEXT* data) {
  (void)guarded([&] {
    for (const auto& listener : listeners(from(instance))) send(listener, severity, types, *data);
    return VK_SUCCESS;
  });
}

VkResult api::CreateDebugReportCallbackEXT(VkInstance instance, const VkDebugReportCallbackCreateInfoEXT* info,
                                           const VkAllocationCallbacks* callbacks, VkDebugReportCallbackEXT* out) {
  return guarded([&] {
    *out = VK_NULL_HANDLE;
    auto callback = make_object<DebugReportCallback>(Allocator(callbacks, from(instance)->allocator),
                                                     VK_SYSTEM_ALLOCATION_SCOPE_OBJECT, *from(instance), *info);
    install_sink();
    const std::scoped_lock lock(registry().mutex);
    registry().callbacks.push_back(callback.get());
    *out = to_handle(callback.release());
    return VK_SUCCESS;
  });
}

void api::DestroyDebugReportCallbackEXT(VkInstance instance, VkDebugReportCallbackEXT callback,
                                        const VkAllocationCallbacks* callbacks) {
  if (!callback) return;
  {
    const std::scoped_lock lock(registry().mutex);
    std::erase(registry().callbacks, from(callback));
  }
  destroy_object(from(callback), callbacks, from(instance)->allocator);
}

void api::DebugReportMessageEXT(VkInstance instance, VkDebugReportFlagsEXT flags, VkDebugReportObjectTypeEXT type,
                                uint64_t object, size_t location, int32_t code, const char* prefix, const char* message) {
  (void)guarded([&] {
    for (const auto& listener : report_listeners(from(instance))) {
      if (listener.flags & flags)
        (void)listener.pfnCallback(flags, type, object, location, code, prefix, message, listener.pUserData);
    }
    return VK_SUCCESS;
  });
}

VkResult api::SetDebugUtilsObjectNameEXT(VkDevice device, const VkDebugUtilsObjectNameInfoEXT* info) {
  return guarded([&] {
    from(device)->set_name(info->objectHandle, info->pObjectName ? info->pObjectName : "");
    return VK_SUCCESS;
  });
}

// Tags are for tools that look inside the driver's objects; there is none.
VkResult api::SetDebugUtilsObjectTagEXT(VkDevice, const VkDebugUtilsObjectTagInfoEXT*) { return VK_SUCCESS; }

}  // namespace pineda::icd
