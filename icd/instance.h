// VkInstance: its extensions, the one physical device, the debug messengers.
#pragma once

#include "icd/dispatch.h"
#include "icd/object.h"
#include "icd/physical_device.h"

namespace pineda::icd {

class Instance : public Dispatchable, public Object {
 public:
  Instance(const Allocator& from, uint32_t gates) : Object(from), physical_device(*this), gates_(gates) {}
  ~Instance();

  // Commands of device extensions exist for the instance whether a device enables them or not.
  bool has(Gate gate) const { return gate == kCore || ((gates_ | kDeviceGates) & gate) != 0; }

  PhysicalDevice physical_device;

 private:
  const uint32_t gates_;  // Gate bits of the enabled extensions
};

}  // namespace pineda::icd
