// The functions that general kernels sample with (DrawContext::sample): one for each state of image view and sampler and each
// kind of request that a kernel has met, compiled when the first one meets it. General kernels are those that were not
// specialised for what is bound (the first draws of a pipeline, and whatever indexes its descriptors by values).
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "compiler/compile.h"

namespace pineda::compiler {

class SampleFunctions {
 public:
  // What the ids in descriptors stand for.
  using Resolve = std::function<TextureState(uint32_t view_id, uint32_t sampler_id)>;
  explicit SampleFunctions(Resolve resolve);
  ~SampleFunctions();

  // For DrawContext::sample; valid while this object lives. A request that no function can be made for gives zeros, and is
  // reported once. Any number of threads may call it.
  const KernelHandle* handle() const { return &handle_; }

 private:
  struct Entry;
  static void run(const KernelHandle* self, const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
                  const void* waves);
  const KernelHandle* find(uint64_t signature, uint32_t view_id, uint32_t sampler_id) const noexcept;
  std::unique_ptr<Entry> make(uint64_t signature, uint32_t view_id, uint32_t sampler_id) const;

  static constexpr uint32_t kBuckets = 1024;
  const Resolve resolve_;
  KernelHandle handle_;
  mutable std::array<std::atomic<const Entry*>, kBuckets> buckets_{};  // heads of lists that only grow, at the front
  mutable std::mutex mutex_;                                           // held while a function is made
  mutable std::vector<std::unique_ptr<Entry>> entries_;                // guarded by mutex_
};

}  // namespace pineda::compiler
