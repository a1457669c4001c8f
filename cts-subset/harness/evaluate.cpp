#include "cts-subset/harness/evaluate.h"

#include <fmt/format.h>

#include <cstring>
#include <stdexcept>

#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kMaxInputs = 256;

std::string shader_text(const Snippet& snippet, const char* interface_lines, const char* index, const char* store) {
  return fmt::format(
      "{}\nlayout(set = 0, binding = 0, std140) uniform Inputs {{ uvec4 inputs[{}]; }};\n{}\n"
      "void main() {{\n  uint at = {};\n  uvec4 a = inputs[at * 3u], b = inputs[at * 3u + 1u], c = inputs[at * 3u + 2u], r = "
      "uvec4(0);\n"
      "  {{\n{}\n  }}\n{}\n}}\n",
      snippet.functions, kMaxInputs * 3, interface_lines, index, snippet.body, store);
}

// Triangle i covers pixel i of a row of kMaxInputs, and no other pixel's centre.
constexpr const char* kOnePixelEach =
    "  vec2 corner = vec2(gl_VertexIndex % 3 == 1 ? 2.0 : 0.0, gl_VertexIndex % 3 == 2 ? 2.0 : 0.0);\n"
    "  gl_Position = vec4((float(at) + corner.x * 0.75 + 0.125) / 128.0 - 1.0, corner.y * 2.0 - 1.0, 0.5, 1.0);";

std::vector<Words4> evaluate_compute(Device& device, const Snippet& snippet, Resources resources, size_t count) {
  const Buffer output = create_buffer(device, kMaxInputs * sizeof(Words4));
  resources.descriptors.push_back(storage_buffer(1, output));
  const std::string text = shader_text(
      snippet, "layout(local_size_x = 16) in;\nlayout(set = 0, binding = 1, std430) buffer Outputs { uvec4 outputs[]; };",
      "gl_GlobalInvocationID.x", "  outputs[at] = r;");
  dispatch(device, compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT, text, snippet.spirv_minor), resources, {kMaxInputs / 16, 1, 1});
  const auto results = output.as<Words4>();
  return {results.begin(), results.begin() + static_cast<ptrdiff_t>(count)};
}

std::vector<Words4> evaluate_graphics(Device& device, VkShaderStageFlagBits stage, const Snippet& snippet, Resources resources,
                                      size_t count) {
  DrawState state;
  state.resources = std::move(resources);
  if (stage == VK_SHADER_STAGE_VERTEX_BIT) {
    const std::string text = shader_text(snippet, "layout(location = 0) flat out uvec4 result;", "uint(gl_VertexIndex / 3)",
                                         (std::string("  result = r;\n") + kOnePixelEach).c_str());
    state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT, text, snippet.spirv_minor);
    state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                                  "layout(location = 0) flat in uvec4 result; layout(location = 0) out uvec4 colour;"
                                  "void main() { colour = result; }");
    state.vertices = kMaxInputs * 3;
  } else {
    state.vertex = fullscreen_vertex();
    const std::string text =
        shader_text(snippet, "layout(location = 0) out uvec4 colour;", "uint(gl_FragCoord.x)", "  colour = r;");
    state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, text, snippet.spirv_minor);
  }
  const std::vector<std::byte> pixels = draw_once(device, state, {kMaxInputs, 1}, VK_FORMAT_R32G32B32A32_UINT);
  std::vector<Words4> results(count);
  std::memcpy(results.data(), pixels.data(), count * sizeof(Words4));
  return results;
}

}  // namespace

std::vector<Words4> evaluate(Device& device, VkShaderStageFlagBits stage, const Snippet& snippet,
                             const std::vector<Arguments>& inputs) {
  if (inputs.size() > kMaxInputs) throw std::logic_error("too many inputs");
  const Buffer input = create_buffer(device, kMaxInputs * sizeof(Arguments));
  std::memcpy(input.mapped, inputs.data(), inputs.size() * sizeof(Arguments));
  Resources resources;
  resources.descriptors = snippet.descriptors;
  resources.descriptors.push_back(uniform_buffer(0, input));
  if (stage == VK_SHADER_STAGE_COMPUTE_BIT) return evaluate_compute(device, snippet, std::move(resources), inputs.size());
  return evaluate_graphics(device, stage, snippet, std::move(resources), inputs.size());
}

}  // namespace pineda::cts
