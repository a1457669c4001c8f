#include "compiler/kernel_cache.h"

#include <map>
#include <mutex>

namespace pineda::compiler {
namespace {

struct Entry {
  std::mutex mutex;  // held while the passes run
  std::weak_ptr<Executable> executable;
};

class Cache {
 public:
  std::shared_ptr<Entry> entry(const KernelHash& hash) {
    const std::lock_guard lock(mutex_);
    if (entries_.size() >= next_sweep_) sweep();
    std::shared_ptr<Entry>& found = entries_[hash];
    if (!found) found = std::make_shared<Entry>();
    return found;
  }

 private:
  // Drops entries whose kernel is gone and that nobody is about to fill.
  void sweep() {
    std::erase_if(entries_, [](const auto& item) {
      if (item.second.use_count() != 1) return false;
      // Nobody holds it any more, but a count says nothing about what its last holder has stored: the mutex does.
      const std::lock_guard lock(item.second->mutex);
      return item.second->executable.expired();
    });
    next_sweep_ = 2 * entries_.size() + 64;
  }

  std::mutex mutex_;
  std::map<KernelHash, std::shared_ptr<Entry>> entries_;
  size_t next_sweep_ = 64;
};

Cache& cache() {
  static Cache& instance = *new Cache;  // never destroyed: kernels may outlive static destructors
  return instance;
}

}  // namespace

Result<ExecutablePtr> cached_executable(ir::Kernel kernel, CodeStore* store) {
  const KernelHash hash = hash_kernel(kernel);
  const std::shared_ptr<Entry> entry = cache().entry(hash);
  const std::lock_guard lock(entry->mutex);
  if (ExecutablePtr known = entry->executable.lock()) return known;
  Result<ExecutablePtr> made = make_executable(std::move(kernel), hash, store);
  if (made) entry->executable = *made;
  return made;
}

}  // namespace pineda::compiler
