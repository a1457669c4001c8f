#include "icd/unbound_set.h"

#include <sys/mman.h>

#include <new>

#include "icd/descriptor_set.h"

namespace pineda::icd {

UnboundSet::UnboundSet() : memory_(mmap(nullptr, kMaxSetBytes, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)) {
  if (memory_ == MAP_FAILED) throw std::bad_alloc();
}

UnboundSet::~UnboundSet() { munmap(memory_, kMaxSetBytes); }

}  // namespace pineda::icd
