// VK_EXT_debug_utils: every message of base/log.h's report() goes to the messengers of every instance in the process (the
// compiler, which speaks most, knows no instance). Object names are kept by the device (Device::set_name) and appear in dumps and
// error messages.
#pragma once

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

// When an instance dies with messengers alive (invalid, but applications exit this way): they hear nothing more.
void remove_messengers(const Instance& instance);

}  // namespace pineda::icd
