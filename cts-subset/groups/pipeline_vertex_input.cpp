// pipeline.vertex_input: every vertex format, at both input rates and at odd offsets and strides, against the formats'
// definition.
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/formats.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kCount = 256;

struct InputCase {
  VkVertexInputRate rate = VK_VERTEX_INPUT_RATE_VERTEX;
  uint32_t offset = 0, padding = 0;  // bytes before the attribute, and behind it up to the stride
};

// Triangle n covers pixel n; its first vertex carries the attribute to the pixel.
constexpr const char* kVertexShader =
    "layout(location = 0) in {0}vec4 fetched; layout(location = 0) flat out {0}vec4 value;\n"
    "void main() {{ value = fetched; int at = {1}; int corner = gl_VertexIndex % 3;\n"
    "  gl_Position = vec4((float(at) + (corner == 1 ? 1.5 : 0.0) + 0.125) / 128.0 - 1.0, corner == 2 ? 3.0 : -1.0, 0.5, 1.0); }}";

void run(Device& device, const FormatInfo& info, const InputCase& c) {
  require(device.format(info.format).bufferFeatures & VK_FORMAT_FEATURE_VERTEX_BUFFER_BIT, "this vertex format");
  const bool instanced = c.rate == VK_VERTEX_INPUT_RATE_INSTANCE;
  const uint32_t stride = c.offset + info.bytes + c.padding, elements = instanced ? kCount : kCount * 3;
  std::vector<std::byte> content(size_t{stride} * elements);
  Random random(info.name);
  for (std::byte& b : content) b = static_cast<std::byte>(random.below(256));
  const Buffer buffer = create_buffer(device, content);

  const Numeric numeric = info.channels[0].numeric;
  const char* prefix = numeric == Numeric::kUint ? "u" : numeric == Numeric::kSint ? "i" : "";
  const VkFormat target_format = numeric == Numeric::kUint   ? VK_FORMAT_R32G32B32A32_UINT
                                 : numeric == Numeric::kSint ? VK_FORMAT_R32G32B32A32_SINT
                                                             : VK_FORMAT_R32G32B32A32_SFLOAT;
  DrawState state;
  state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT, fmt::format(fmt::runtime(kVertexShader), prefix,
                                                                      instanced ? "gl_InstanceIndex" : "gl_VertexIndex / 3"));
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                                fmt::format("layout(location = 0) flat in {0}vec4 value; layout(location = 0) out {0}vec4 colour;"
                                            "void main() {{ colour = value; }}",
                                            prefix));
  state.input.bindings = {{0, stride, c.rate}};
  state.input.attributes = {{0, 0, info.format, c.offset}};
  state.input.buffers = {&buffer};
  state.vertices = instanced ? 3 : kCount * 3;
  state.instances = instanced ? kCount : 1;
  const std::vector<std::byte> pixels = draw_once(device, state, {kCount, 1}, target_format);
  for (uint32_t n = 0; n < kCount; ++n) {
    const Colour want = decode(info, content.data() + size_t{instanced ? n : n * 3} * stride + c.offset);
    for (uint32_t i = 0; i < 4; ++i) {
      uint32_t word;
      std::memcpy(&word, pixels.data() + (n * 4 + i) * 4, 4);
      const double got = info.is_integer()
                             ? (numeric == Numeric::kUint ? double{1.0 * word} : double{1.0 * static_cast<int32_t>(word)})
                             : double{std::bit_cast<float>(word)};
      const bool same = std::isnan(want[i])
                            ? std::isnan(got)
                            : got == want[i] || (!info.is_integer() && std::abs(got - want[i]) <= std::abs(want[i]) * 0x1p-22) ||
                                  (std::abs(want[i]) < 0x1p-126 && got == 0);
      expect(same, fmt::format("element {}, component {}: {:.9g}, not {:.9g}", n, i, got, want[i]));
    }
  }
}

}  // namespace

void register_pipeline_vertex_input() {
  for (const FormatInfo& info : colour_formats()) {
    const auto add = [&](const char* name, const InputCase& c) {
      add_case("pipeline.vertex_input", fmt::format("{}.{}", info.name, name),
               "22.1 Vertex Attributes, 22.3 Vertex Attribute Divisor", [&info, c](Device& device) { run(device, info, c); });
    };
    const uint32_t component_bytes = std::max(1u, info.channels.back().bits / 8);
    const uint32_t unit = info.bytes % component_bytes == 0 && info.channels.front().bits == info.channels.back().bits
                              ? component_bytes
                              : info.bytes;
    add("per_vertex", {});
    add("per_instance", {VK_VERTEX_INPUT_RATE_INSTANCE, 0, 0});
    add("offset", {VK_VERTEX_INPUT_RATE_VERTEX, unit, unit * 2});
  }
}

}  // namespace pineda::cts
