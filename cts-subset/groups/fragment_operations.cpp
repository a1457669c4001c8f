// fragment_operations.*: scissors, early tests, discard, sample masks, depth from the shader, and the fragment's built-ins.
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 24;

std::vector<uint32_t> draw_words(Device& device, const DrawState& state, VkExtent2D extent = {kSize, kSize}) {
  const std::vector<std::byte> bytes = draw_once(device, state, extent, VK_FORMAT_R32_UINT);
  std::vector<uint32_t> words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), bytes.size());
  return words;
}

Spirv writes(const std::string& body) {
  return compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, "layout(location = 0) out uint c;\n" + body);
}

void run_scissor(Device& device, const VkRect2D& scissor) {
  DrawState state;
  state.vertex = fullscreen_vertex();
  state.fragment = writes("void main() { c = 1u; }");
  state.scissors = {scissor};
  const std::vector<uint32_t> got = draw_words(device, state);
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      const auto in = [](uint32_t at, int32_t offset, uint32_t extent) {
        return at >= static_cast<uint32_t>(offset) && uint64_t{at} < static_cast<uint64_t>(offset) + extent;
      };
      const bool want = in(x, scissor.offset.x, scissor.extent.width) && in(y, scissor.offset.y, scissor.extent.height);
      expect((got[y * kSize + x] != 0) == want, fmt::format("pixel {}, {} is {}drawn", x, y, want ? "not " : ""));
    }
  }
}

Image create_attachment(Device& device, VkFormat format, VkImageUsageFlags usage) {
  ImageDesc desc;
  desc.format = format;
  desc.extent = {kSize, kSize, 1};
  desc.usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | usage;
  return create_image(device, desc);
}

struct EarlyCase {
  bool early, passes, discards;
};
// A counter in the shader tells whether it ran for fragments that fail the depth test, and a discarded one keeps its depth.
void run_early_tests(Device& device, const EarlyCase& c) {
  require(device.caps().features.fragmentStoresAndAtomics, "fragmentStoresAndAtomics");
  const Image colour = create_attachment(device, VK_FORMAT_R32_UINT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
  const Image depth = create_attachment(device, VK_FORMAT_D16_UNORM, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
  const Buffer counter = create_buffer(device, 4);
  Target target;
  target.colours.push_back({&colour, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  target.depth_stencil = Attachment{&depth, VK_ATTACHMENT_LOAD_OP_CLEAR, {.depthStencil = {c.passes ? 1.0f : 0.0f, 0}}};
  DrawState state;
  state.vertex = fullscreen_vertex(0.5f);
  state.fragment =
      writes(fmt::format("{}layout(binding = 0, std430) buffer B {{ uint n; }};\n"
                         "void main() {{ atomicAdd(n, 1u); {} c = 1u; }}",
                         c.early ? "layout(early_fragment_tests) in;\n" : "", c.discards ? "discard;" : ""));
  state.resources.descriptors = {storage_buffer(0, counter)};
  state.depth_stencil.depthTestEnable = state.depth_stencil.depthWriteEnable = VK_TRUE;
  state.depth_stencil.depthCompareOp = VK_COMPARE_OP_LESS;
  Pass pass(device, target);
  pass.add(state);
  pass.run();
  const uint32_t ran = counter.as<uint32_t>()[0], want = c.early && !c.passes ? 0 : kSize * kSize;
  expect(ran == want, fmt::format("the shader's side effect came from {} fragments, not {}", ran, want));
  const auto depths = download_as<uint16_t>(device, depth, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, 0, 0, VK_IMAGE_ASPECT_DEPTH_BIT);
  const auto colours = download_as<uint32_t>(device, colour, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const bool drawn = c.passes && !c.discards;
  // With early tests the depth is written before the shader discards.
  const bool depth_written = c.passes && (c.early || !c.discards);
  for (size_t i = 0; i < depths.size(); ++i) {
    expect((colours[i] != 0) == drawn, fmt::format("colour of pixel {}", i));
    const bool is_half = depths[i] == 32767 || depths[i] == 32768;
    expect(is_half == depth_written, fmt::format("depth of pixel {} is {}", i, depths[i]));
  }
}

// gl_FragDepth with each qualifier that the value respects; compared with what a buffer of depths says.
void run_frag_depth(Device& device, const char* qualifier, VkFormat format, VkCompareOp op) {
  require(device.format(format).optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT, "depth format");
  const bool greater = std::string_view(qualifier) == "depth_greater", less = std::string_view(qualifier) == "depth_less";
  const bool same = std::string_view(qualifier) == "depth_unchanged";
  Random random(qualifier);
  std::vector<float> values(kSize * kSize);
  for (float& v : values) {
    const double u = random.unit();
    v = static_cast<float>(same ? 0.5 : greater ? 0.5 + u / 2 : less ? u / 2 : u);
  }
  const Buffer buffer = create_buffer(device, values);
  const Image colour = create_attachment(device, VK_FORMAT_R32_UINT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
  const Image depth = create_attachment(device, format, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
  Target target;
  target.colours.push_back({&colour, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  target.depth_stencil = Attachment{&depth, VK_ATTACHMENT_LOAD_OP_CLEAR, {.depthStencil = {0.625f, 0}}};
  DrawState state;
  state.vertex = fullscreen_vertex(0.5f);
  state.fragment = compile_glsl(
      VK_SHADER_STAGE_FRAGMENT_BIT,
      fmt::format("{}layout(location = 0) out uint c; layout(binding = 0, std430) readonly buffer B {{ float d[]; }};\n"
                  "void main() {{ c = 1u; gl_FragDepth = d[uint(gl_FragCoord.y) * {}u + uint(gl_FragCoord.x)]; }}",
                  *qualifier ? fmt::format("layout({}) out float gl_FragDepth;\n", qualifier) : "", kSize));
  state.resources.descriptors = {storage_buffer(0, buffer)};
  state.depth_stencil.depthTestEnable = state.depth_stencil.depthWriteEnable = VK_TRUE;
  state.depth_stencil.depthCompareOp = op;
  Pass pass(device, target);
  pass.add(state);
  pass.run();
  const auto colours = download_as<uint32_t>(device, colour, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const double step = format == VK_FORMAT_D16_UNORM ? 1.0 / 65535 : 1e-7;
  for (size_t i = 0; i < values.size(); ++i) {
    const double distance = values[i] - 0.625;
    if (std::abs(distance) < 2 * step) continue;
    const bool want = op == VK_COMPARE_OP_LESS ? distance < 0 : op == VK_COMPARE_OP_GREATER ? distance > 0 : true;
    expect((colours[i] != 0) == want, fmt::format("depth {} {} 0.625", values[i], want ? "failed against" : "passed against"));
  }
}

// gl_FragCoord of every pixel, with depth and 1/w of a perspective plane.
void run_frag_coord(Device& device, float w0, float w1) {
  DrawState state;
  state.vertex = compile_glsl(
      VK_SHADER_STAGE_VERTEX_BIT,
      fmt::format("void main() {{ vec2 p = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1); float w = p.x == 0.0 ? {:.6f} : {:.6f};"
                  " gl_Position = vec4((p * 2.0 - 1.0) * w, p.y * w, w); }}",
                  w0, w1));
  state.fragment =
      compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, "layout(location = 0) out vec4 c; void main() { c = gl_FragCoord; }");
  state.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
  state.vertices = 4;
  const std::vector<std::byte> bytes = draw_once(device, state, {kSize, kSize}, VK_FORMAT_R32G32B32A32_SFLOAT);
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      float got[4];
      std::memcpy(got, bytes.data() + (y * kSize + x) * 16, 16);
      const double tx = (x + 0.5) / kSize, ty = (y + 0.5) / kSize;
      expect(got[0] == static_cast<float>(x + 0.5) && got[1] == static_cast<float>(y + 0.5),
             fmt::format("pixel {}, {}: gl_FragCoord.xy is {}, {}", x, y, got[0], got[1]));
      const double depth = ty, inverse_w = (1 - tx) / w0 + tx / w1;
      expect(std::abs(got[2] - depth) < 2e-5, fmt::format("pixel {}, {}: depth {}, not {}", x, y, got[2], depth));
      expect(std::abs(got[3] - inverse_w) < 2e-5 * std::max(1 / w0, 1 / w1),
             fmt::format("pixel {}, {}: 1/w {}, not {}", x, y, got[3], inverse_w));
    }
  }
}

// gl_FrontFacing for each winding, front face and negative viewport height.
void run_front_facing(Device& device, bool clockwise, VkFrontFace front, bool flipped, VkCullModeFlags cull) {
  if (flipped)
    require(device.caps().api_version >= VK_API_VERSION_1_1 || device.has_extension(VK_KHR_MAINTENANCE_1_EXTENSION_NAME),
            "maintenance1");
  DrawState state;
  state.vertex =
      compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                   fmt::format("void main() {{ int i = {}; gl_Position = vec4(vec2(i & 1, i >> 1) * 4.0 - 1.0, 0.5, 1.0); }}",
                               clockwise ? "gl_VertexIndex" : "2 - gl_VertexIndex"));
  state.fragment = writes("void main() { c = gl_FrontFacing ? 1u : 2u; }");
  state.rasterization.frontFace = front;
  state.rasterization.cullMode = cull;
  if (flipped) state.viewports = {{0, kSize, kSize, -static_cast<float>(kSize), 0, 1}};
  const std::vector<uint32_t> got = draw_words(device, state);
  // Vertices (-1,-1), (3,-1), (-1,3): clockwise on the screen, where y points down.
  const bool is_clockwise = clockwise != flipped;
  const bool is_front = is_clockwise == (front == VK_FRONT_FACE_CLOCKWISE);
  const bool culled = (is_front && (cull & VK_CULL_MODE_FRONT_BIT)) || (!is_front && (cull & VK_CULL_MODE_BACK_BIT));
  const uint32_t want = culled ? 0 : is_front ? 1 : 2;
  for (const uint32_t value : got) expect(value == want, fmt::format("{}, not {}", value, want));
}

// discard, in every shape of control flow: the same pixels as the condition computed here.
struct DiscardCase {
  const char* name;
  const char* body;  // of uint x, y; sets k
  bool (*kept)(uint32_t x, uint32_t y);
};
constexpr DiscardCase kDiscards[] = {
    {"always", "discard;", [](uint32_t, uint32_t) { return false; }},
    {"if", "if ((x ^ y) % 3u == 0u) discard;", [](uint32_t x, uint32_t y) { return (x ^ y) % 3 != 0; }},
    {"else", "if (x > y) k = 5u; else discard;", [](uint32_t x, uint32_t y) { return x > y; }},
    {"loop", "for (uint i = 0u; i < 30u; ++i) { if (i * i == x + y) discard; }",
     [](uint32_t x, uint32_t y) {
       for (uint32_t i = 0; i < 30; ++i) {
         if (i * i == x + y) return false;
       }
       return true;
     }},
    {"switch", "switch (x % 4u) { case 1u: discard; case 2u: if (y % 2u == 0u) discard; break; default: break; }",
     [](uint32_t x, uint32_t y) { return x % 4 != 1 && !(x % 4 == 2 && y % 2 == 0); }},
    {"function", "f(x * y % 5u);", [](uint32_t x, uint32_t y) { return x * y % 5 < 2; }},
    {"nested", "if (x > 5u) { for (uint i = 0u; i < y; ++i) { if (i == 7u) { if (x % 2u == 1u) discard; break; } } }",
     [](uint32_t x, uint32_t y) { return !(x > 5 && y > 7 && x % 2 == 1); }},
};

void run_discard(Device& device, const DiscardCase& c) {
  DrawState state;
  state.vertex = fullscreen_vertex();
  state.fragment =
      writes(fmt::format("uint k = 5u; void f(uint v) {{ if (v > 1u) discard; }}\n"
                         "void main() {{ uint x = uint(gl_FragCoord.x), y = uint(gl_FragCoord.y); {}\n c = k; }}",
                         c.body));
  const std::vector<uint32_t> got = draw_words(device, state);
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      expect(got[y * kSize + x] == (c.kept(x, y) ? 5u : 0u), fmt::format("pixel {}, {}", x, y));
    }
  }
}

// A rectangle over clip space: covered is what the viewport's rectangle covers, with the depth that its range gives.
void run_viewport(Device& device, const VkViewport& viewport) {
  DrawState state;
  state.vertex =
      compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                   "void main() { vec2 p = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1); gl_Position = vec4(p * 2.0 - 1.0,"
                   " 0.5, 1.0); }");
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                                "layout(location = 0) out vec4 c; void main() { c = vec4(1.0, gl_FragCoord.z, 0.0, 1.0); }");
  state.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
  state.vertices = 4;
  state.viewports = {viewport};
  const std::vector<std::byte> bytes = draw_once(device, state, {kSize, kSize}, VK_FORMAT_R32G32B32A32_SFLOAT);
  const double x0 = viewport.x, x1 = viewport.x + viewport.width, y0 = std::min(viewport.y, viewport.y + viewport.height),
               y1 = std::max(viewport.y, viewport.y + viewport.height);
  const double depth = viewport.minDepth + (double{viewport.maxDepth} - viewport.minDepth) * 0.5;
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      float got[4];
      std::memcpy(got, bytes.data() + (y * kSize + x) * 16, 16);
      const double inside = std::min({x + 0.5 - x0, x1 - x - 0.5, y + 0.5 - y0, y1 - y - 0.5});
      if (std::abs(inside) < 1.0 / 16) continue;
      expect((got[0] != 0) == (inside > 0), fmt::format("pixel {}, {}", x, y));
      if (inside > 0) expect(std::abs(got[1] - depth) < 1e-5, fmt::format("depth {}, not {}", got[1], depth));
    }
  }
}

}  // namespace

void register_fragment_operations() {
  for (const VkRect2D& scissor : {VkRect2D{{0, 0}, {kSize, kSize}},
                                  {{0, 0}, {0, 0}},
                                  {{3, 5}, {7, 2}},
                                  {{23, 23}, {1, 1}},
                                  {{0, 11}, {24, 1}},
                                  {{8, 8}, {8, 8}},
                                  {{5, 0}, {1, 24}},
                                  {{24, 0}, {8, 8}},
                                  {{4, 4}, {0x7FFFFFF0, 0x7FFFFFF0}},
                                  {{1, 1}, {22, 22}}}) {
    add_case("fragment_operations.scissor",
             fmt::format("{}_{}_{}x{}", scissor.offset.x, scissor.offset.y, scissor.extent.width, scissor.extent.height),
             "28.1 Scissor Test", [scissor](Device& device) { run_scissor(device, scissor); });
  }
  for (int bits = 0; bits < 8; ++bits) {
    const EarlyCase c{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
    add_case("fragment_operations.early_fragment",
             fmt::format("{}_{}{}", c.early ? "early" : "late", c.passes ? "passes" : "fails", c.discards ? "_discards" : ""),
             "27.1.1 Early Fragment Test Mode", [c](Device& device) { run_early_tests(device, c); });
  }
  static constexpr std::pair<VkFormat, const char*> kDepths[] = {{VK_FORMAT_D16_UNORM, "d16"},
                                                                 {VK_FORMAT_D32_SFLOAT, "d32"},
                                                                 {VK_FORMAT_X8_D24_UNORM_PACK32, "x8_d24"},
                                                                 {VK_FORMAT_D24_UNORM_S8_UINT, "d24_s8"},
                                                                 {VK_FORMAT_D32_SFLOAT_S8_UINT, "d32_s8"}};
  for (const char* qualifier : {"", "depth_any", "depth_greater", "depth_less", "depth_unchanged"}) {
    for (const auto& [format, name] : kDepths) {
      for (const auto& [op, op_name] : {std::pair{VK_COMPARE_OP_LESS, "less"}, {VK_COMPARE_OP_GREATER, "greater"}}) {
        add_case("fragment_operations.frag_depth", fmt::format("{}_{}_{}", *qualifier ? qualifier : "plain", name, op_name),
                 "27.8 Depth Replacement",
                 [=, format = format, op = op](Device& device) { run_frag_depth(device, qualifier, format, op); });
      }
    }
  }
  for (const auto& [w0, w1] : {std::pair{1.0f, 1.0f}, {1.0f, 2.0f}, {4.0f, 0.25f}, {100.0f, 1.0f}, {0.01f, 0.02f}}) {
    add_case("fragment_operations.frag_coord", fmt::format("w_{}_to_{}", w0, w1), "15.8 Built-In Variables: FragCoord",
             [w0 = w0, w1 = w1](Device& device) { run_frag_coord(device, w0, w1); });
  }
  for (int bits = 0; bits < 8; ++bits) {
    for (const auto& [cull, cull_name] : {std::pair<VkCullModeFlags, const char*>{VK_CULL_MODE_NONE, "none"},
                                          {VK_CULL_MODE_FRONT_BIT, "front"},
                                          {VK_CULL_MODE_BACK_BIT, "back"},
                                          {VK_CULL_MODE_FRONT_AND_BACK, "both"}}) {
      const VkFrontFace front = bits & 2 ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE;
      add_case("fragment_operations.front_facing",
               fmt::format("{}_front_{}{}_cull_{}", bits & 1 ? "clockwise" : "counter", bits & 2 ? "clockwise" : "counter",
                           bits & 4 ? "_flipped" : "", cull_name),
               "27.12.1 Basic Polygon Rasterization",
               [=, cull = cull](Device& device) { run_front_facing(device, bits & 1, front, bits & 4, cull); });
    }
  }
  for (const DiscardCase& c : kDiscards) {
    add_case("fragment_operations.discard", c.name, "SPIR-V 3.42.17 OpKill", [&c](Device& device) { run_discard(device, c); });
  }
  const std::vector<std::pair<const char*, VkViewport>> viewports = {
      {"whole", {0, 0, kSize, kSize, 0, 1}},
      {"part", {3, 5, 11, 7, 0, 1}},
      {"fraction", {2.5f, 3.25f, 10.75f, 9.5f, 0, 1}},
      {"outside_left", {-10, 2, 20, 10, 0, 1}},
      {"larger", {-100, -50, 300, 200, 0, 1}},
      {"reversed_depth", {0, 0, kSize, kSize, 1, 0}},
      {"narrow_depth", {0, 0, kSize, kSize, 0.25f, 0.375f}},
      {"flipped", {0, kSize, kSize, -static_cast<float>(kSize), 0, 1}},
      {"empty_depth", {0, 0, kSize, kSize, 0.5f, 0.5f}}};
  for (const auto& [name, viewport] : viewports) {
    add_case("fragment_operations.viewport", name, "26.9 Controlling the Viewport",
             [viewport = viewport](Device& device) { run_viewport(device, viewport); });
  }
}

}  // namespace pineda::cts
