#include "compiler/sample_functions.h"

#include <bit>
#include <new>

#include "base/log.h"
#include "compiler/kernels/sample_call.h"

namespace pineda::compiler {

struct SampleFunctions::Entry {
  uint64_t signature;
  uint32_t view_id, sampler_id;
  KernelPtr kernel;  // null: there is no such function
  const Entry* next = nullptr;

  bool is(uint64_t s, uint32_t view, uint32_t sampler) const {
    return signature == s && view_id == view && sampler_id == sampler;
  }
};

namespace {

constexpr uint32_t kAllLanes = (1u << kLanes) - 1;

void zero_results(SampleCall& call) {
  for (auto& row : call.result) {
    for (uint32_t l = 0; l < kLanes; ++l) {
      if (call.mask >> l & 1) row[l] = 0;
    }
  }
}

uint32_t hash(uint64_t signature, uint32_t view_id, uint32_t sampler_id) {
  const uint64_t ids = static_cast<uint64_t>(view_id) << 32 | sampler_id;
  return static_cast<uint32_t>((signature * 0x9E3779B97F4A7C15ull ^ ids * 0xC2B2AE3D27D4EB4Full) >> 40);
}

}  // namespace

SampleFunctions::SampleFunctions(Resolve resolve) : resolve_(std::move(resolve)), handle_{&SampleFunctions::run, this} {}
SampleFunctions::~SampleFunctions() = default;

std::unique_ptr<SampleFunctions::Entry> SampleFunctions::make(uint64_t signature, uint32_t view_id, uint32_t sampler_id) const {
  const auto request = kernels::SampleSignature::unpack(signature);
  TextureState state = resolve_(view_id, sampler_id);
  if (view_id == 0) state.view_type = request.view_type;  // a null image fits every shader
  auto entry = std::make_unique<Entry>(Entry{signature, view_id, sampler_id, nullptr});
  Result<ir::Kernel> kernel = kernels::build_sample_function(state, request);
  Result<KernelPtr> compiled = kernel ? compile_kernel(std::move(*kernel)) : std::unexpected(kernel.error());
  if (compiled) {
    entry->kernel = std::move(*compiled);
  } else {
    report(Severity::kError, "a texture cannot be sampled as a shader asks: " + compiled.error().text);
  }
  return entry;
}

// Null when there is no such function, or no memory to make it. Machine code calls this, so nothing may be thrown.
const KernelHandle* SampleFunctions::find(uint64_t signature, uint32_t view_id, uint32_t sampler_id) const noexcept try {
  std::atomic<const Entry*>& bucket = buckets_[hash(signature, view_id, sampler_id) % kBuckets];
  const auto look = [&]() -> const Entry* {
    const Entry* entry = bucket.load(std::memory_order_acquire);
    while (entry && !entry->is(signature, view_id, sampler_id)) entry = entry->next;
    return entry;
  };
  const auto handle_of = [](const Entry& entry) { return entry.kernel ? &entry.kernel->handle : nullptr; };
  if (const Entry* known = look()) return handle_of(*known);
  const std::lock_guard lock(mutex_);
  if (const Entry* known = look()) return handle_of(*known);
  std::unique_ptr<Entry> made = make(signature, view_id, sampler_id);
  made->next = bucket.load(std::memory_order_relaxed);
  entries_.push_back(std::move(made));
  bucket.store(entries_.back().get(), std::memory_order_release);
  return handle_of(*entries_.back());
} catch (const std::bad_alloc&) {
  return nullptr;
}

// Lanes whose descriptors are the same go together; mostly all do.
void SampleFunctions::run(const KernelHandle* self, const void* draw, void* thread, const PrimRecord*, uint32_t,
                          const void* waves) {
  const auto& functions = *static_cast<const SampleFunctions*>(self->self);
  SampleCall& call = *static_cast<SampleCall*>(const_cast<void*>(waves));
  const uint32_t active = call.mask & kAllLanes;
  const PrimRecord prim{nullptr, 0, 1};
  for (uint32_t left = active; left != 0; left &= ~call.mask) {
    const auto first = static_cast<uint32_t>(std::countr_zero(left));
    call.image = call.image_of_lane[first];
    call.sampler = call.sampler_of_lane[first];
    call.mask = 0;
    for (uint32_t l = first; l < kLanes; ++l) {
      const bool same = call.image_of_lane[l] == call.image && call.sampler_of_lane[l] == call.sampler;
      call.mask |= static_cast<uint32_t>(same) << l;
    }
    call.mask &= left;
    const bool fetch = call.sampler == call.image;  // no sampler: the words there are an image's
    const uint32_t view_id = reinterpret_cast<const ImageDescriptor*>(call.image)->state_id;
    const uint32_t sampler_id = fetch ? 0 : reinterpret_cast<const SamplerDescriptor*>(call.sampler)->state_id;
    const KernelHandle* function = functions.find(call.signature, view_id, sampler_id);
    if (function) {
      (*function)(draw, thread, &prim, 1, &call);
    } else {
      zero_results(call);
    }
  }
  call.mask = active;
}

}  // namespace pineda::compiler
