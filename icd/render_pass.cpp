#include "icd/render_pass.h"

#include <algorithm>
#include <bit>
#include <span>
#include <stdexcept>

#include "base/format.h"
#include "base/sample_locations.h"
#include "icd/api.h"
#include "icd/chain.h"
#include "icd/device.h"
#include "icd/render_pass_info.h"

namespace pineda::icd {
namespace {

const VkSubpassDescriptionDepthStencilResolve* depth_resolve(const VkSubpassDescription2& subpass) {
  const auto* found = find_in_chain<VkSubpassDescriptionDepthStencilResolve>(
      subpass.pNext, VK_STRUCTURE_TYPE_SUBPASS_DESCRIPTION_DEPTH_STENCIL_RESOLVE);
  const bool used =
      found && found->pDepthStencilResolveAttachment && found->pDepthStencilResolveAttachment->attachment != VK_ATTACHMENT_UNUSED;
  return used ? found : nullptr;
}

// Calls f(attachment index) for every reference of the subpass that is used.
template <typename F>
void for_references(const VkSubpassDescription2& subpass, const F& f) {
  const auto visit = [&](const VkAttachmentReference2* references, uint32_t count) {
    for (uint32_t i = 0; references && i < count; ++i) {
      if (references[i].attachment != VK_ATTACHMENT_UNUSED) f(references[i].attachment);
    }
  };
  visit(subpass.pInputAttachments, subpass.inputAttachmentCount);
  visit(subpass.pColorAttachments, subpass.colorAttachmentCount);
  visit(subpass.pResolveAttachments, subpass.colorAttachmentCount);
  visit(subpass.pDepthStencilAttachment, 1);
  if (const auto* resolve = depth_resolve(subpass)) visit(resolve->pDepthStencilResolveAttachment, 1);
}

VkResult check_subpass(const VkRenderPassCreateInfo2& info, const VkSubpassDescription2& subpass) {
  if (subpass.pipelineBindPoint != VK_PIPELINE_BIND_POINT_GRAPHICS)
    return not_supported("vkCreateRenderPass: bind point is not graphics");
  if (subpass.colorAttachmentCount > kMaxColorAttachments)
    return not_supported("vkCreateRenderPass: more than 8 colour attachments");
  bool known = true;
  for_references(subpass, [&](uint32_t index) { known &= index < info.attachmentCount; });
  if (!known) return not_supported("vkCreateRenderPass: an attachment's index is out of range");
  // "All attachments ... that are not VK_ATTACHMENT_UNUSED must have the same sample count"
  uint32_t samples = 0;
  const auto same_samples = [&](const VkAttachmentReference2* reference) {
    if (!reference || reference->attachment == VK_ATTACHMENT_UNUSED) return true;
    const auto own = static_cast<uint32_t>(info.pAttachments[reference->attachment].samples);
    const bool same = samples == 0 || samples == own;
    samples = own;
    return same;
  };
  bool same = same_samples(subpass.pDepthStencilAttachment);
  for (uint32_t i = 0; i < subpass.colorAttachmentCount; ++i) same &= same_samples(&subpass.pColorAttachments[i]);
  if (!same) return not_supported("vkCreateRenderPass: attachments of one subpass have different numbers of samples");
  return VK_SUCCESS;
}

SubpassAttachment reference(const VkRenderPassCreateInfo2& info, const VkAttachmentReference2* from) {
  SubpassAttachment to;
  if (!from || from->attachment == VK_ATTACHMENT_UNUSED) return to;
  to.index = from->attachment;
  to.format = info.pAttachments[to.index].format;
  return to;
}

compiler::KernelPtr resolve_kernel(VkFormat format, uint32_t samples, VkResolveModeFlagBits mode) {
  if (format == VK_FORMAT_UNDEFINED || mode == VK_RESOLVE_MODE_NONE) return nullptr;
  Result<compiler::KernelPtr> kernel = compiler::compile_resolve(format, samples, mode);
  if (!kernel) throw std::runtime_error("vkCreateRenderPass: " + kernel.error().text);
  return *kernel;
}

void add_resolves(const VkSubpassDescription2& description, Subpass& subpass) {
  for (uint32_t i = 0; description.pResolveAttachments && i < description.colorAttachmentCount; ++i) {
    SubpassAttachment& color = subpass.color[i];
    color.resolve_index = description.pResolveAttachments[i].attachment;
    if (color.resolve_index == VK_ATTACHMENT_UNUSED || color.index == VK_ATTACHMENT_UNUSED) continue;
    color.resolve = resolve_kernel(color.format, subpass.samples, VK_RESOLVE_MODE_AVERAGE_BIT);
  }
  const auto* resolve = depth_resolve(description);
  if (!resolve || subpass.depth.index == VK_ATTACHMENT_UNUSED) return;
  subpass.depth.resolve_index = resolve->pDepthStencilResolveAttachment->attachment;
  const VkFormat format = subpass.depth.format;
  subpass.depth.resolve =
      resolve_kernel(aspect_format(format, VK_IMAGE_ASPECT_DEPTH_BIT), subpass.samples, resolve->depthResolveMode);
  subpass.depth.stencil_resolve =
      resolve_kernel(aspect_format(format, VK_IMAGE_ASPECT_STENCIL_BIT), subpass.samples, resolve->stencilResolveMode);
}

bool draws_to(const Subpass& subpass, uint32_t index) {
  const auto is = [&](const SubpassAttachment& use) { return use.index == index; };
  return is(subpass.depth) || std::any_of(subpass.color.begin(), subpass.color.begin() + subpass.color_count, is);
}

bool reads(const VkSubpassDescription2& subpass, uint32_t index) {
  return std::any_of(subpass.pInputAttachments, subpass.pInputAttachments + subpass.inputAttachmentCount,
                     [&](const VkAttachmentReference2& r) { return r.attachment == index; });
}

}  // namespace

VkResult RenderPass::check(Device&, const VkRenderPassCreateInfo2& info) {
  for (uint32_t i = 0; i < info.attachmentCount; ++i) {
    const VkAttachmentDescription2& attachment = info.pAttachments[i];
    const auto samples = static_cast<uint32_t>(attachment.samples);
    if (!std::has_single_bit(samples) || !(samples & kSampleCounts)) {
      return not_supported("vkCreateRenderPass: an attachment has a number of samples that is not supported");
    }
    const FormatInfo* format = find_format(attachment.format);
    if (!format || !(format->uses & (kUseColor | kUseDepth))) {
      return not_supported("vkCreateRenderPass: format " + std::to_string(attachment.format) + " cannot be an attachment");
    }
  }
  for (uint32_t i = 0; i < info.subpassCount; ++i) {
    if (const VkResult result = check_subpass(info, info.pSubpasses[i]); result != VK_SUCCESS) return result;
  }
  return VK_SUCCESS;
}

RenderPass::RenderPass(const Allocator& from, Device&, const VkRenderPassCreateInfo2& info)
    : Object(from), attachment_count_(info.attachmentCount), subpasses_(info.subpassCount, HostAllocator<Subpass>(&allocator)) {
  for (uint32_t s = 0; s < info.subpassCount; ++s) {
    const VkSubpassDescription2& description = info.pSubpasses[s];
    Subpass& subpass = subpasses_[s];
    subpass.view_mask = description.viewMask;
    subpass.color_count = description.colorAttachmentCount;
    for (uint32_t i = 0; i < subpass.color_count; ++i) subpass.color[i] = reference(info, &description.pColorAttachments[i]);
    subpass.depth = reference(info, description.pDepthStencilAttachment);
    for (uint32_t i = 0; i < info.attachmentCount; ++i) {
      if (!draws_to(subpass, i)) continue;
      subpass.samples = static_cast<uint32_t>(info.pAttachments[i].samples);
      subpass.reads_own_output |= reads(description, i);
    }
    add_resolves(description, subpass);
  }
  for (uint32_t index = 0; index < info.attachmentCount; ++index) set_operations(info, index);
  set_order(info);
}

// Render passes run beside each other only where their attachments lie in different memory. So of the dependencies on commands
// outside those between attachments always hold; those with other commands hold because these run alone, but may be one half of a
// chain: "render pass -> transfer" and "transfer -> fragment shader" order two render passes. Hence the lists below: a dependency
// counts unless, with every one that could continue it, it leaves no more than attachments after attachments.
void RenderPass::set_order(const VkRenderPassCreateInfo2& info) {
  constexpr VkPipelineStageFlags kAttachments = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                                VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                                VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
  constexpr VkPipelineStageFlags kAlone = VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_HOST_BIT;
  const auto only = [](VkPipelineStageFlags stages, VkPipelineStageFlags of) { return (stages & ~of) == 0; };
  for (uint32_t i = 0; i < info.dependencyCount; ++i) {
    const VkSubpassDependency2& d = info.pDependencies[i];
    if (d.srcSubpass == VK_SUBPASS_EXTERNAL) {
      const bool nothing = only(d.srcStageMask, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT);
      const bool attachments =
          only(d.srcStageMask, kAttachments | kAlone | VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT) && only(d.dstStageMask, kAttachments);
      waits_for_passes_ |= !nothing && !attachments;
    }
    if (d.dstSubpass == VK_SUBPASS_EXTERNAL) {
      const bool nothing = only(d.dstStageMask, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT);
      const bool attachments = only(d.srcStageMask, kAttachments) &&
                               only(d.dstStageMask, kAttachments | kAlone | VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT);
      awaited_by_passes_ |= !nothing && !attachments;
    }
  }
  // An application that leaves an image ready to be sampled is likely to do so, even if it says no more than this.
  for (uint32_t i = 0; i < info.attachmentCount; ++i) {
    const VkImageLayout layout = info.pAttachments[i].finalLayout;
    awaited_by_passes_ |= layout == VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL || layout == VK_IMAGE_LAYOUT_GENERAL ||
                          layout == VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL;
  }
}

// The attachment's first use loads, its last one stores. A resolve replaces everything in the render area, so it loads nothing,
// and is always stored.
void RenderPass::set_operations(const VkRenderPassCreateInfo2& info, uint32_t index) {
  const VkAttachmentDescription2& attachment = info.pAttachments[index];
  SubpassAttachment* last = nullptr;
  bool used = false;
  for (uint32_t s = 0; s < info.subpassCount; ++s) {
    Subpass& subpass = subpasses_[s];
    bool in_subpass = false;
    for_references(info.pSubpasses[s], [&](uint32_t i) { in_subpass |= i == index; });
    if (!in_subpass) continue;
    const bool first = !used, is_read = reads(info.pSubpasses[s], index);
    used = true;
    if (first && is_read) {
      SubpassAttachment cleared{.index = index, .format = attachment.format};
      cleared.load = attachment.loadOp;
      cleared.stencil_load = attachment.stencilLoadOp;
      subpass.cleared_first.push_back(cleared);
    }
    const auto visit = [&](SubpassAttachment& use) {
      if (use.index != index) return;
      if (first && !is_read) {
        use.load = attachment.loadOp;
        use.stencil_load = attachment.stencilLoadOp;
      }
      last = &use;
    };
    if (is_read || !draws_to(subpass, index)) last = nullptr;  // a later read or resolve: what was drawn before stays in memory
    for (SubpassAttachment& use : std::span(subpass.color).first(subpass.color_count)) visit(use);
    visit(subpass.depth);
  }
  if (!last) return;
  last->store = attachment.storeOp;
  last->stencil_store = attachment.stencilStoreOp;
}

VkResult api::CreateRenderPass2KHR(VkDevice device, const VkRenderPassCreateInfo2* info, const VkAllocationCallbacks* callbacks,
                                   VkRenderPass* out) {
  return create_device_object<RenderPass>(device, info, callbacks, out);
}

VkResult api::CreateRenderPass(VkDevice device, const VkRenderPassCreateInfo* info, const VkAllocationCallbacks* callbacks,
                               VkRenderPass* out) {
  *out = VK_NULL_HANDLE;
  return guarded([&] { return CreateRenderPass2KHR(device, &RenderPassInfo2(*info).info(), callbacks, out); });
}

void api::DestroyRenderPass(VkDevice device, VkRenderPass render_pass, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, render_pass, callbacks);
}

// Render areas need no alignment: clears and stores are clipped to them exactly.
void api::GetRenderAreaGranularity(VkDevice, VkRenderPass, VkExtent2D* out) { *out = {1, 1}; }

}  // namespace pineda::icd
