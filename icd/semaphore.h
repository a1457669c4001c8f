// VkSemaphore. The device has one queue that executes in order, and a binary semaphore may only be waited for after the operation
// that signals it has been submitted: every wait is satisfied by order, so there is no state.
#pragma once

#include "icd/object.h"

namespace pineda::icd {

class Semaphore : public Object {
 public:
  Semaphore(const Allocator& from, Device&, const VkSemaphoreCreateInfo&) : Object(from) {}
};

}  // namespace pineda::icd
