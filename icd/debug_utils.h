// VK_EXT_debug_utils: every message of base/log.h's report() goes to the messengers of every instance in the process (the
// compiler, which speaks most, knows no instance). Object names are kept by the device (Device::set_name) and appear in dumps and
// error messages.
#pragma once

#include <string>
#include <vector>

#include "icd/labels.h"
#include "icd/object.h"

namespace pineda::icd {

class DebugMessenger : public Object {
 public:
  DebugMessenger(const Allocator& from, Instance& owner, const VkDebugUtilsMessengerCreateInfoEXT& create_info)
      : Object(from), instance(owner), info(create_info) {}

  Instance& instance;
  const VkDebugUtilsMessengerCreateInfoEXT info;
};

// VK_EXT_debug_report, what came before: the same messages.
class DebugReportCallback : public Object {
 public:
  DebugReportCallback(const Allocator& from, Instance& owner, const VkDebugReportCallbackCreateInfoEXT& create_info)
      : Object(from), instance(owner), info(create_info) {}

  Instance& instance;
  const VkDebugReportCallbackCreateInfoEXT info;
};

// While it exists, messages that this thread reports are about this object, and about what the queue executes: messengers get the
// handle, its name and the labels around.
class MessageScope {
 public:
  // `handle` may be null, `queue` too.
  MessageScope(const Device& device, VkObjectType type, uint64_t handle, const Queue* queue = nullptr);
  ~MessageScope();
  MessageScope(const MessageScope&) = delete;

  void describe(VkDebugUtilsMessengerCallbackDataEXT* data) const;
  std::string text() const;  // the same for a sentence about a command buffer; may be empty

 private:
  const MessageScope* const outer_;
  const std::string name_;
  std::vector<VkDebugUtilsObjectNameInfoEXT> objects_;
  std::vector<Label> queue_labels_, command_labels_;
  mutable std::vector<VkDebugUtilsLabelEXT> queue_infos_, command_infos_;  // of the last describe()
};

// When an instance dies with messengers alive (invalid, but applications exit this way): they hear nothing more.
void remove_messengers(const Instance& instance);

}  // namespace pineda::icd
