#include "icd/explain.h"

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <unordered_set>

#include "base/config.h"
#include "base/format.h"
#include "base/log.h"
#include "icd/explain_text.h"

namespace pineda::icd {
namespace {

using compiler::FragmentState;

// ---- pipelines ------------------------------------------------------------------------------------------------------------

std::string sizes_text(const char* stage, const compiler::KernelSizes& sizes) {
  const uint32_t removed = sizes.built > sizes.kept ? sizes.built - sizes.kept : 0;
  return std::string(stage) + ": " + share(removed, sizes.built) +
         " IR instructions removed as dead, constant or equal to others; " + "of the " + number(sizes.kept) + " left " +
         number(sizes.per_draw) + " run once a draw and " + number(sizes.per_primitive) + " once a primitive; loads " +
         number(sizes.built_loads) + " -> " + number(sizes.loads) + ", stores " + number(sizes.built_stores) + " -> " +
         number(sizes.stores);
}

void explain_varyings(const spirv::ModuleInfo& vertex, const compiler::GraphicsSizes& sizes, std::string& text) {
  uint32_t written = 0;
  std::string removed;
  for (const spirv::InterfaceScalar& out : vertex.outputs) {
    if (out.built_in) continue;
    ++written;
    if (std::ranges::find(sizes.varyings, compiler::VaryingSlot{out.location, out.component}) != sizes.varyings.end()) continue;
    removed += " " + number(out.location) + "." + std::string(1, "xyzw"[out.component & 3]);
  }
  if (removed.empty()) return line(text, "varyings: all " + number(written) + " components are read");
  line(text, "varyings:" + removed + " removed from both stages, as no value that is stored depends on them; " +
                 number(sizes.varyings.size()) + " of " + number(written) + " left");
}

void explain_depth_stencil(const FragmentState& state, const compiler::GraphicsKernels& kernels, std::string& text) {
  const compiler::DepthState& depth = state.depth;
  if (depth.format == VK_FORMAT_UNDEFINED) {
    line(text, "depth: no code, there is no attachment");
  } else if (!depth.test_enable) {
    line(text, "depth: no load, test or store, the test is off");
  } else {
    std::string what = "depth: ";
    if (depth.compare == VK_COMPARE_OP_ALWAYS) what += "no comparison (ALWAYS), ";
    if (!depth.write_enable) what += "no store (writes are off), ";
    line(text, what + (kernels.early_depth ? "tested before the shader, so blocks behind are never shaded"
                                           : "tested after the shader, which discards, writes depth or has side effects"));
  }
  if (!state.stencil.test_enable) {
    line(text, "stencil: no code, the test is off");
  } else if (!state.stencil.writes()) {
    line(text, "stencil: no store, every operation is KEEP");
  }
}

bool ignores_destination(VkBlendFactor factor) { return factor == VK_BLEND_FACTOR_ZERO; }

void explain_colours(const FragmentState& state, const spirv::ModuleInfo* fragment, std::string& text) {
  for (uint32_t i = 0; i < state.color_count; ++i) {
    const compiler::BlendState& blend = state.color[i];
    const std::string name = "colour " + number(i) + ": ";
    const FormatInfo* const format = find_format(blend.format);
    if (!format) {
      line(text, name + "no code, the attachment is unused");
      continue;
    }
    std::string what;
    for (uint32_t channel = 0; channel < 4; ++channel) {
      if (!(blend.write_mask >> channel & 1)) what += std::string(what.empty() ? "channels " : "") + "rgba"[channel];
    }
    if (!what.empty()) what += " not computed (write mask); ";
    if (!blend.blend_enable) {
      what += "no blend terms, the old value is not loaded";
    } else {
      if (ignores_destination(blend.dst_color) && ignores_destination(blend.dst_alpha))
        what += "destination terms removed (factor ZERO); ";
      if (blend.dst_color == VK_BLEND_FACTOR_ONE) what += "no multiplication of the destination (factor ONE); ";
      if (blend.src_color == VK_BLEND_FACTOR_ONE) what += "no multiplication of the source (factor ONE); ";
      what += "blended";
    }
    line(text, name + what);
  }
  if (!fragment) return;
  std::string unused;
  for (const spirv::InterfaceScalar& out : fragment->outputs) {
    if (out.built_in || out.location < state.color_count) continue;
    unused += " " + number(out.location) + "." + std::string(1, "xyzw"[out.component & 3]);
  }
  if (!unused.empty()) line(text, "outputs" + unused + " removed, they have no attachment");
}

// ---- passes ---------------------------------------------------------------------------------------------------------------

struct Traffic {
  uint64_t whole_bytes = 0;  // what loading and storing every attachment once would move
  std::string left_out;
};

void add_attachment(const raster::PassDesc& pass, const raster::Attachment& attachment, const std::string& name,
                    Traffic& traffic) {
  if (!attachment.address) return;
  const uint64_t bytes = uint64_t{pass.render_area.extent.width} * pass.render_area.extent.height *
                         texel_bytes(attachment.format) * std::max(1u, attachment.samples);
  traffic.whole_bytes += 2 * bytes;
  if (attachment.load == VK_ATTACHMENT_LOAD_OP_CLEAR) traffic.left_out += name + " is cleared in its tiles, not loaded; ";
  if (attachment.load == VK_ATTACHMENT_LOAD_OP_DONT_CARE) traffic.left_out += name + " is not loaded (DONT_CARE); ";
  if (attachment.store != VK_ATTACHMENT_STORE_OP_STORE) traffic.left_out += name + " never leaves its tiles (DONT_CARE); ";
  if (attachment.resolve_address) traffic.left_out += name + " is resolved in its tiles; ";
}

}  // namespace

std::string form_text(bool samples, bool specialized) {
  return !samples ? "'" : specialized ? "', specialised for its textures" : "', its general form";
}

std::string explain_pipeline(const std::string& name, const spirv::ModuleInfo& vertex, const spirv::ModuleInfo* fragment,
                             const FragmentState& state, const compiler::GraphicsKernels& kernels,
                             const compiler::GraphicsSizes& sizes) {
  std::string text = "pipeline '" + name;
  line(text, sizes_text("vertex kernel", sizes.vertex));
  line(text, sizes_text("fragment kernel (interpolation, shader, tests, blending, packing)", sizes.fragment));
  explain_varyings(vertex, sizes, text);
  explain_depth_stencil(state, kernels, text);
  explain_colours(state, fragment, text);
  if (kernels.opaque) line(text, "opaque: where a triangle covers a whole tile, what was drawn before is dropped unshaded");
  if (state.samples > 1 && !kernels.per_sample) {
    line(text, "samples: shaded once a pixel, not " + number(state.samples) + " times" +
                   (state.equal_samples ? "; the colours of a block are kept once while its samples are equal" : ""));
  }
  return text;
}

std::string explain_pass(const raster::PassDesc& pass, const raster::PassStatistics& s) {
  std::string text = "render pass, " + number(pass.render_area.extent.width) + "x" + number(pass.render_area.extent.height) +
                     ", " + number(pass.samples) + (pass.samples == 1 ? " sample, " : " samples, ") + number(s.draws) + " draws";
  if (s.vertices_in > s.vertices_shaded) {
    line(text, "vertices: " + share(s.vertices_in - s.vertices_shaded, s.vertices_in) +
                   " not shaded, their results were there already");
  }
  line(text, "triangles: " + share(s.triangles_culled, s.triangles_in) + " dropped before any tile: " + number(s.culled_facing) +
                 " without area or of a culled face, " + number(s.culled_no_sample) +
                 " that cover no sample, the others outside the picture");
  if (s.blocks_hi_z_rejected) {
    line(text, "shading: " + share(s.blocks_hi_z_rejected, s.blocks_hi_z_rejected + s.blocks_shaded) +
                   " of the 4x4 blocks rejected by hierarchical depth, unshaded");
  } else {
    line(text, "shading: " + number(s.blocks_shaded) + " 4x4 blocks, none rejected by hierarchical depth");
  }
  const uint64_t tiles = s.tiles_touched + s.tiles_filled + s.tiles_untouched;
  line(text, "tiles: " + share(s.tiles_filled, tiles) + " filled with the clear colour, never opened; " +
                 number(s.tiles_untouched) + " left as they were");
  Traffic traffic;
  for (uint32_t i = 0; i < pass.color_count; ++i) add_attachment(pass, pass.color[i], "colour " + number(i), traffic);
  add_attachment(pass, pass.depth, "depth", traffic);
  add_attachment(pass, pass.stencil, "stencil", traffic);
  line(text, "memory: " + traffic.left_out + number(s.bytes_loaded) + " bytes loaded and " + number(s.bytes_stored) +
                 " stored, where loading and storing every attachment takes " + number(traffic.whole_bytes));
  return text;
}

void say_once(const std::string& text) {
  constexpr size_t kMostTexts = 4096;  // of an application that never draws the same twice
  static std::mutex mutex;
  static std::unordered_set<std::string> said;
  const std::lock_guard lock(mutex);
  if (said.size() >= kMostTexts || !said.insert(text).second) return;
  if (config().debug_dir.empty()) {
    std::fprintf(stderr, "pineda: %s\n", text.c_str());
    return;
  }
  const std::string path = config().debug_dir + "/explain.txt";
  std::FILE* const file = std::fopen(path.c_str(), "ae");
  const bool written = file && std::fputs((text + "\n").c_str(), file) >= 0;
  if (!file || std::fclose(file) != 0 || !written) report(Severity::kWarning, path + " cannot be written");
}

}  // namespace pineda::icd
