// VkPipelineCache: the machine code of the kernels that pipelines were created with, by key (compiler/code_store.h).
//
// Its data: VkPipelineCacheHeaderVersionOne, then one record for each kernel: RecordHeader with a checksum, the code, zeros up to
// a multiple of 8. Data that an application brings back may be cut short, changed or somebody else's: a header that is not ours
// to the last byte empties the cache, and reading ends at the first record that is not whole or not what its checksum says.
#pragma once

#include <map>
#include <mutex>
#include <span>
#include <vector>

#include "compiler/code_store.h"
#include "icd/object.h"

namespace pineda::icd {

// Changes with whatever changes the content of a cache: the build, and with it the bits and the format.
void get_pipeline_cache_uuid(uint8_t (&out)[VK_UUID_SIZE]);

class PipelineCache : public Object, public compiler::CodeStore {
 public:
  PipelineCache(const Allocator& from, Device&, const VkPipelineCacheCreateInfo& info);

  compiler::CodeBlob find(const compiler::KernelHash& key) override;
  void insert(const compiler::KernelHash& key, const compiler::CodeBlob& blob) override;
  void insert_when_finished(const compiler::ExecutablePtr& kernel) override;

  void merge(PipelineCache& other);
  // As vkGetPipelineCacheData: whole records only.
  VkResult get_data(size_t* size_bytes, void* data);

 private:
  void load(std::span<const uint8_t> data);
  // Waits for the kernels whose code is not there yet. One whose code fails is left out: who runs it hears of it.
  void settle();

  std::mutex unfinished_mutex_;  // guards unfinished_; before mutex_
  std::vector<compiler::ExecutablePtr> unfinished_;
  std::mutex mutex_;  // guards blobs_
  std::map<compiler::KernelHash, compiler::CodeBlob> blobs_;
};

}  // namespace pineda::icd
