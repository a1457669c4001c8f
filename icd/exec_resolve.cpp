// Execution of vkCmdResolveImage: a render pass without draws, whose only attachment is loaded and resolved.
#include "icd/device.h"
#include "icd/executor.h"
#include "icd/transfer.h"

namespace pineda::icd {

const compiler::Kernel* Executor::resolve_kernel(VkFormat format, uint32_t samples) {
  compiler::KernelPtr& kernel = resolve_kernels_[{format, samples}];
  if (!kernel) {
    Result<compiler::KernelPtr> made = compiler::compile_resolve(format, samples, VK_RESOLVE_MODE_AVERAGE_BIT);
    if (!made) {
      device_.lose("vkCmdResolveImage: " + made.error().text);
      return nullptr;
    }
    kernel = *made;
  }
  return kernel.get();
}

void Executor::execute(const cmd::ResolveImage& command) {
  const Image &source = *command.source, &destination = *command.destination;
  const bool fits = destination.sample_count == 1 && source.format.format == destination.format.format &&
                    !source.format.is_depth_or_stencil() && (source.format.uses & kUseColor);
  if (pass_ || !fits) return;  // invalid usage
  for (const VkImageResolve& region : command.regions) {
    const BlockExtent extent{region.extent.width, region.extent.height, 1};
    const auto from = image_region(source, region.srcSubresource, region.srcOffset, extent);
    const auto to = image_region(destination, region.dstSubresource, region.dstOffset, extent);
    const compiler::Kernel* kernel = from && to ? resolve_kernel(source.format.format, source.sample_count) : nullptr;
    if (!kernel) continue;
    for (uint32_t layer = 0; layer < std::min(from->slices, to->slices); ++layer) {
      raster::PassDesc desc;
      desc.extent = {from->columns, from->row_count};
      desc.render_area.extent = desc.extent;
      desc.samples = source.sample_count;
      desc.color_count = 1;
      raster::Attachment& a = desc.color[0];
      a.address = from->rows.address + layer * from->rows.slice_pitch_bytes;
      a.row_pitch_bytes = static_cast<uint32_t>(from->rows.row_pitch_bytes);
      a.format = source.format.format;
      a.store = VK_ATTACHMENT_STORE_OP_DONT_CARE;
      a.samples = source.sample_count;
      a.sample_pitch_bytes = from->sample_pitch_bytes;
      a.resolve = kernel->handle;
      a.resolve_address = to->rows.address + layer * to->rows.slice_pitch_bytes;
      a.resolve_row_pitch_bytes = static_cast<uint32_t>(to->rows.row_pitch_bytes);
      raster::Pass(device_.pool, desc).end();
    }
  }
}

}  // namespace pineda::icd
