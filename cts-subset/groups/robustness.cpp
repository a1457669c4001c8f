// robustness.*: accesses outside of what is bound, as robustBufferAccess limits them, and as robustBufferAccess2 and
// robustImageAccess2 define them where offered.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kWords = 64;           // of the bound range
constexpr uint32_t kGuard = 0xA5A5A5A5u;  // around it, in the same buffer

struct Access {
  const char* name;
  const char* type;  // of an element
  uint32_t words;
};
constexpr Access kAccesses[] = {
    {"uint", "uint", 1}, {"uvec2", "uvec2", 2}, {"uvec4", "uvec4", 4}, {"float", "float", 1}, {"mat4", "mat4", 16}};
constexpr uint32_t kIndices[] = {0,   1,    15,          63,          64,          65,          100,
                                 127, 4096, 0x10000000u, 0x3FFFFFFFu, 0x40000000u, 0x7FFFFFFFu, 0xFFFFFFFFu};

// Reads elements at in- and out-of-range indices. What is outside must come from the buffer's memory or be zero; with
// robustBufferAccess (1) any value of the *bound range*, or zero, or (0, 0, 0, x).
void run_load(Device& device, const Access& access, bool uniform) {
  const uint32_t range_words = kWords;
  Random random(access.name);
  const VkDeviceSize alignment = 256;
  std::vector<uint32_t> content(alignment / 4 + range_words + alignment / 4, kGuard);
  for (uint32_t i = 0; i < range_words; ++i) content[alignment / 4 + i] = 1 + random.below(1000);
  const Buffer in = create_buffer(device, content);
  const Buffer index_buffer = create_buffer(device, std::vector<uint32_t>(std::begin(kIndices), std::end(kIndices)));
  const size_t count = std::size(kIndices);
  const Buffer out = create_buffer(device, count * access.words * 4, kAnyBuffer, 0xFF);
  Resources resources;
  resources.descriptors = {
      uniform ? uniform_buffer(0, in, alignment, range_words * 4) : storage_buffer(0, in, alignment, range_words * 4),
      storage_buffer(1, index_buffer), storage_buffer(2, out)};
  const uint32_t stride = uniform ? std::max(4u, access.words) : access.words;
  std::string parts;
  for (uint32_t w = 0; w < access.words; ++w) {
    const std::string component = access.words == 16  ? fmt::format("v[{}][{}]", w / 4, w % 4)
                                  : access.words == 1 ? std::string("v")
                                                      : fmt::format("v[{}]", w);
    const bool is_float = access.type[0] == 'f' || access.type[0] == 'm';
    parts += fmt::format("o[i * {}u + {}u] = {}; ", access.words, w, is_float ? "floatBitsToUint(" + component + ")" : component);
  }
  const std::string block =
      uniform ? fmt::format("layout(binding = 0, std140) uniform B {{ {} data[{}]; }};", access.type, kWords / stride)
              : fmt::format("layout(binding = 0, std430) readonly buffer B {{ {} data[]; }};", access.type);
  dispatch(device,
           compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                        fmt::format("layout(local_size_x = {}) in; {}\n"
                                    "layout(binding = 1, std430) readonly buffer I {{ uint indices[]; }};\n"
                                    "layout(binding = 2, std430) buffer O {{ uint o[]; }};\n"
                                    "void main() {{ uint i = gl_LocalInvocationIndex; {} v = data[indices[i]]; {} }}",
                                    count, block, access.type, parts)),
           resources);
  for (size_t i = 0; i < count; ++i) {
    for (uint32_t w = 0; w < access.words; ++w) {
      const uint32_t got = out.as<uint32_t>()[i * access.words + w];
      const uint64_t at = uint64_t{kIndices[i]} * stride + w;
      const std::string where = fmt::format("index {:#x}, word {}: {:#x}", kIndices[i], w, got);
      if (at < range_words) {
        expect(got == content[alignment / 4 + at], where + " is not what the buffer holds");
      } else {
        const bool from_range =
            std::find(content.begin() + 64, content.begin() + 64 + range_words, got) != content.begin() + 64 + range_words;
        const bool is_w = w % 4 == 3 && (got == 1 || got == 0x3F800000 || got == 0x7FFFFFFF || got == 0xFFFFFFFF);
        expect(got == 0 || from_range || is_w, where + " comes from outside of the bound range");
      }
    }
  }
}

// Writes at the same indices: nothing outside of the bound range may change.
void run_store(Device& device, const Access& access, bool atomic) {
  std::vector<uint32_t> content(64 + kWords + 64, kGuard);
  const Buffer data = create_buffer(device, content);
  const Buffer index_buffer = create_buffer(device, std::vector<uint32_t>(std::begin(kIndices), std::end(kIndices)));
  Resources resources;
  resources.descriptors = {storage_buffer(0, data, 256, kWords * 4), storage_buffer(1, index_buffer)};
  dispatch(device,
           compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                        fmt::format("layout(local_size_x = {}) in; layout(binding = 0, std430) buffer B {{ {} data[]; }};\n"
                                    "layout(binding = 1, std430) readonly buffer I {{ uint indices[]; }};\n"
                                    "void main() {{ uint i = gl_LocalInvocationIndex; {} }}",
                                    std::size(kIndices), access.type,
                                    atomic ? "atomicExchange(data[indices[i]], 7u);"
                                           : fmt::format("data[indices[i]] = {}(7);", access.type))),
           resources);
  const auto got = data.as<uint32_t>();
  for (uint32_t i = 0; i < 64; ++i) {
    expect(got[i] == kGuard, fmt::format("word {} before the range changed", 64 - i));
    expect(got[64 + kWords + i] == kGuard, fmt::format("word {} behind the range changed", i));
  }
  for (const uint32_t index : kIndices) {
    const uint64_t at = uint64_t{index} * access.words;
    if (at + access.words <= kWords) expect(got[64 + at] != kGuard, fmt::format("element {} was not written", index));
  }
}

// Vertex attributes beyond the end of their buffer, or of the binding's range.
void run_vertex(Device& device, uint32_t vertices_there) {
  const Buffer out = create_buffer(device, 16 * 16, kAnyBuffer, 0xFF);
  require(device.caps().features.vertexPipelineStoresAndAtomics, "vertexPipelineStoresAndAtomics");
  std::vector<uint32_t> content(vertices_there * 4);
  for (size_t i = 0; i < content.size(); ++i) content[i] = static_cast<uint32_t>(i) + 100;
  const Buffer vertices = create_buffer(device, content);
  DrawState state;
  state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                              "layout(location = 0) in uvec4 v; layout(binding = 0, std430) buffer O { uvec4 o[]; };\n"
                              "void main() { o[gl_VertexIndex] = v; gl_Position = vec4(0); gl_PointSize = 1.0; }");
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, "layout(location = 0) out vec4 c; void main() { c = vec4(1); }");
  state.input.bindings = {{0, 16, VK_VERTEX_INPUT_RATE_VERTEX}};
  state.input.attributes = {{0, 0, VK_FORMAT_R32G32B32A32_UINT, 0}};
  state.input.buffers = {&vertices};
  state.topology = VK_PRIMITIVE_TOPOLOGY_POINT_LIST;
  state.vertices = 16;
  state.resources.descriptors = {storage_buffer(0, out)};
  draw_once(device, state);
  const auto got = out.as<uint32_t>();
  for (uint32_t i = 0; i < 16 * 4; ++i) {
    if (i < vertices_there * 4) {
      expect(got[i] == i + 100, fmt::format("word {} is {}", i, got[i]));
    } else {
      const bool from_range = got[i] >= 100 && got[i] < 100 + vertices_there * 4;
      expect(got[i] == 0 || from_range || (i % 4 == 3 && got[i] == 1), fmt::format("word {} is {:#x}", i, got[i]));
    }
  }
}

// Fetches and stores outside of an image: loads give zeros or (0, 0, 0, 1), stores nothing.
void run_image(Device& device, bool storage, VkImageViewType view) {
  ImageDesc desc;
  desc.format = VK_FORMAT_R32G32B32A32_UINT;
  desc.extent = {8, view == VK_IMAGE_VIEW_TYPE_1D ? 1u : 8u, 1};
  desc.type = view == VK_IMAGE_VIEW_TYPE_1D ? VK_IMAGE_TYPE_1D : VK_IMAGE_TYPE_2D;
  desc.view_type = view;
  desc.layers = view == VK_IMAGE_VIEW_TYPE_2D_ARRAY ? 3 : 1;
  desc.usage |= VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
  const Image image = create_image(device, desc);
  const size_t words = 8 * desc.extent.height * 4;
  const std::vector<uint32_t> content(words, 9);
  const VkImageLayout layout = storage ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  for (uint32_t layer = 0; layer < desc.layers; ++layer)
    upload(device, image, std::as_bytes(std::span(content)), 0, layer, layout);
  static constexpr int32_t kAt[] = {-1, 8, 9, 1000, 0x7FFFFFFF, -0x7FFFFFFF - 1, 65536};
  const Buffer positions = create_buffer(device, std::vector<int32_t>(std::begin(kAt), std::end(kAt)));
  const Buffer out = create_buffer(device, std::size(kAt) * 16, kAnyBuffer, 0xFF);
  const Sampler sampler = create_sampler(device);
  Resources resources;
  resources.descriptors = {storage ? storage_image(0, image) : sampled_image(0, image, sampler), storage_buffer(1, positions),
                           storage_buffer(2, out)};
  const char* shape = view == VK_IMAGE_VIEW_TYPE_1D ? "1D" : view == VK_IMAGE_VIEW_TYPE_2D ? "2D" : "2DArray";
  const char* position = view == VK_IMAGE_VIEW_TYPE_1D ? "p" : view == VK_IMAGE_VIEW_TYPE_2D ? "ivec2(2, p)" : "ivec3(2, 3, p)";
  const std::string declaration = storage ? fmt::format("layout(binding = 0, rgba32ui) uniform uimage{} t;", shape)
                                          : fmt::format("layout(binding = 0) uniform usampler{} t;", shape);
  const std::string use = storage ? fmt::format("o[i] = imageLoad(t, {0}); imageStore(t, {0}, uvec4(5));", position)
                                  : fmt::format("o[i] = texelFetch(t, {}, 0);", position);
  dispatch(device,
           compile_glsl(
               VK_SHADER_STAGE_COMPUTE_BIT,
               fmt::format("layout(local_size_x = {}) in; {}\nlayout(binding = 1, std430) readonly buffer P {{ int ps[]; }};\n"
                           "layout(binding = 2, std430) buffer O {{ uvec4 o[]; }};\n"
                           "void main() {{ uint i = gl_LocalInvocationIndex; int p = ps[i]; {} }}",
                           std::size(kAt), declaration, use)),
           resources);
  for (size_t i = 0; i < std::size(kAt); ++i) {
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t got = out.as<uint32_t>()[i * 4 + c];
      // Without robustImageAccess fetches outside are undefined, but in the image, so any of its values (all 9) is right, too.
      expect(got == 0 || got == 9 || (c == 3 && got == 1) || (storage && got == 5),
             fmt::format("coordinate {}: {:#x}", kAt[i], got));
    }
  }
  if (storage) {
    for (uint32_t layer = 0; layer < desc.layers; ++layer) {
      const auto now = download_as<uint32_t>(device, image, VK_IMAGE_LAYOUT_GENERAL, 0, layer);
      expect(std::all_of(now.begin(), now.end(), [](uint32_t w) { return w == 9; }), "a store outside changed the image");
      if (layer + 1 < desc.layers) {
        device.run([&](VkCommandBuffer commands) {
          transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL);
        });
      }
    }
  }
}

}  // namespace

void register_robustness() {
  constexpr const char* kSection = "48.1 robustBufferAccess";
  for (const Access& access : kAccesses) {
    add_case("robustness.buffer_access", fmt::format("storage_load_{}", access.name), kSection,
             [&access](Device& device) { run_load(device, access, false); });
    add_case("robustness.buffer_access", fmt::format("uniform_load_{}", access.name), kSection,
             [&access](Device& device) { run_load(device, access, true); });
    add_case("robustness.buffer_access", fmt::format("store_{}", access.name), kSection,
             [&access](Device& device) { run_store(device, access, false); });
  }
  add_case("robustness.buffer_access", "atomic", kSection, [](Device& device) { run_store(device, kAccesses[0], true); });
  for (const uint32_t vertices : {1u, 7u, 15u, 16u}) {
    add_case("robustness.vertex_access", fmt::format("{}_of_16", vertices), kSection,
             [vertices](Device& device) { run_vertex(device, vertices); });
  }
  for (const bool storage : {false, true}) {
    for (const auto& [view, name] :
         {std::pair{VK_IMAGE_VIEW_TYPE_1D, "1d"}, {VK_IMAGE_VIEW_TYPE_2D, "2d"}, {VK_IMAGE_VIEW_TYPE_2D_ARRAY, "2d_array"}}) {
      add_case("robustness.image_access", fmt::format("{}_{}", storage ? "storage" : "fetch", name),
               "16.5.9 Integer Texel Coordinates", [=, view = view](Device& device) { run_image(device, storage, view); });
    }
  }
}

}  // namespace pineda::cts
