// VkInstance: its extensions, the one physical device, the debug messengers.
#pragma once

#include "icd/dispatch.h"
#include "icd/object.h"
#include "icd/physical_device.h"

namespace pineda::icd {

class Instance : public Dispatchable, public Object {
 public:
  Instance(const Allocator& from, const GateSet& gates) : Object(from), physical_device(*this), gates_(gates) {}
  ~Instance();

  // Commands of device extensions exist for the instance whether a device enables them or not.
  bool has(Gate gate) const { return scope_of(gate) == GateScope::kDevice || gates_.has(gate); }

  PhysicalDevice physical_device;

 private:
  const GateSet gates_;  // of the enabled extensions
};

}  // namespace pineda::icd
