// Sampling by descriptor: what a kernel does that was not specialised for its textures, or indexes them by values. The request's
// arguments go into the thread's SampleCall (base/abi.h), DrawContext::sample finds and runs the function for the state of each
// lane's descriptors, and the results come back. Those functions are kernels around sample_image(), so both ways give the same
// bits.
#pragma once

#include "compiler/kernels/sample.h"

namespace pineda::kernels {

// Which function: everything of a request that selects code.
struct SampleSignature {
  enum class Operation : uint8_t { kSample, kFetch, kQueryLod } operation = Operation::kSample;
  VkImageViewType view_type = VK_IMAGE_VIEW_TYPE_2D;
  spirv::LodMode lod_mode = spirv::LodMode::kExplicit;
  bool integer = false;
  bool has_bias = false, has_min_lod = false, has_reference = false, has_dynamic_offset = false, has_sample = false;
  int8_t gather_component = -1;
  std::array<int32_t, 3> offset{};  // -128..127

  bool operator==(const SampleSignature&) const = default;
  uint64_t pack() const;
  static SampleSignature unpack(uint64_t bits);
};

Result<Channels> call_sample(ir::Builder& b, ir::Value image, ir::Value sampler, const spirv::SampleRequest& request);
Result<Channels> call_query_lod(ir::Builder& b, ir::Value image, ir::Value sampler, const spirv::ImageQuery& query);

// The function, as a kernel whose waves are SampleCalls.
Result<ir::Kernel> build_sample_function(const compiler::TextureState& state, const SampleSignature& signature);

}  // namespace pineda::kernels
