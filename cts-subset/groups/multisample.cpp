// pipeline.multisample: coverage at the standard sample locations, masks, alpha to coverage, resolves.
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 16;

struct Location {
  int x, y;  // 1/16 px
};

// "Standard sample locations"
const std::vector<Location>& standard_locations(uint32_t samples) {
  static const std::vector<Location> one = {{8, 8}}, two = {{12, 12}, {4, 4}}, four = {{6, 2}, {14, 6}, {2, 10}, {10, 14}},
                                     eight = {{9, 5}, {7, 11}, {13, 9}, {5, 3}, {3, 13}, {1, 7}, {11, 15}, {15, 1}},
                                     sixteen = {{9, 9},  {7, 5}, {5, 10}, {12, 7}, {3, 6}, {10, 13}, {13, 11}, {11, 3},
                                                {6, 14}, {8, 1}, {4, 2},  {2, 12}, {0, 8}, {15, 4},  {14, 15}, {1, 0}};
  switch (samples) {
    case 1:
      return one;
    case 2:
      return two;
    case 4:
      return four;
    case 8:
      return eight;
    default:
      return sixteen;
  }
}

Image create_target(Device& device, uint32_t samples, VkFormat format = VK_FORMAT_R8G8B8A8_UNORM, VkImageUsageFlags more = 0) {
  ImageDesc desc;
  desc.format = format;
  desc.extent = {kSize, kSize, 1};
  desc.samples = static_cast<VkSampleCountFlagBits>(samples);
  desc.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | more;
  return create_image(device, desc);
}

// Every sample of a multisampled image, fetched by a compute shader: [pixel][sample].
std::vector<uint32_t> fetch_samples(Device& device, const Image& image, uint32_t samples) {
  const Sampler sampler = create_sampler(device);
  const Buffer out = create_buffer(device, kSize * kSize * samples * 4);
  Resources resources;
  resources.descriptors = {sampled_image(0, image, sampler), storage_buffer(1, out)};
  device.run([&](VkCommandBuffer commands) {
    transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  });
  dispatch(
      device,
      compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                   fmt::format("layout(local_size_x = 16, local_size_y = 16) in; layout(binding = 0) uniform sampler2DMS t;\n"
                               "layout(binding = 1, std430) buffer B {{ uint values[]; }};\n"
                               "void main() {{ ivec2 p = ivec2(gl_LocalInvocationID.xy); for (int s = 0; s < {0}; ++s)\n"
                               "  values[(p.y * 16 + p.x) * {0} + s] = packUnorm4x8(texelFetch(t, p, s)); }}",
                               samples)),
      resources);
  const auto values = out.as<uint32_t>();
  return {values.begin(), values.end()};
}

struct Triangle {
  std::array<std::array<int, 2>, 3> p;  // 1/16 px
};

Triangle random_triangle(Random& random) {
  Triangle t;
  for (auto& vertex : t.p) vertex = {static_cast<int>(random.below(kSize * 16)), static_cast<int>(random.below(kSize * 16))};
  return t;
}

DrawState triangle_state(const Triangle& t, uint32_t samples, const char* fragment) {
  std::string vertices;
  for (const auto& p : t.p) vertices += fmt::format("{}vec2({}, {})", vertices.empty() ? "" : ", ", p[0], p[1]);
  DrawState state;
  state.vertex = compile_glsl(
      VK_SHADER_STAGE_VERTEX_BIT,
      fmt::format("void main() {{ vec2 p = vec2[]({})[gl_VertexIndex] / {}.0 - 1.0; gl_Position = vec4(p, 0.5, 1.0); }}",
                  vertices, kSize * 8));
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, fragment);
  state.multisample.rasterizationSamples = static_cast<VkSampleCountFlagBits>(samples);
  return state;
}

// Strictly inside or strictly outside; samples on an edge are not asked.
enum class Side { kInside, kOutside, kOnEdge };
Side side_of(const Triangle& t, int x, int y) {
  int signs[3];
  for (size_t i = 0; i < 3; ++i) {
    const auto &a = t.p[i], &b = t.p[(i + 1) % 3];
    const int64_t e = int64_t{b[0] - a[0]} * (y - a[1]) - int64_t{b[1] - a[1]} * (x - a[0]);
    signs[i] = e > 0 ? 1 : e < 0 ? -1 : 0;
  }
  if (signs[0] == 0 || signs[1] == 0 || signs[2] == 0) return Side::kOnEdge;
  return signs[0] == signs[1] && signs[1] == signs[2] ? Side::kInside : Side::kOutside;
}

constexpr const char* kWhite = "layout(location = 0) out vec4 c; void main() { c = vec4(1.0); }";

void require_samples(Device& device, uint32_t samples) {
  require(device.limits().framebufferColorSampleCounts & samples, "sample count");
  require(device.limits().sampledImageColorSampleCounts & samples, "sampling this sample count");
  require(device.limits().standardSampleLocations, "standardSampleLocations");
}

void run_coverage(Device& device, uint32_t samples, uint32_t seed, uint32_t mask) {
  require_samples(device, samples);
  Random random(fmt::format("coverage{}", seed));
  const Triangle t = random_triangle(random);
  const Image image = create_target(device, samples, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_SAMPLED_BIT);
  Target target;
  target.colours.push_back({&image, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  DrawState state = triangle_state(t, samples, kWhite);
  const VkSampleMask sample_mask = mask;
  state.multisample.pSampleMask = &sample_mask;
  Pass pass(device, target);
  pass.add(state);
  pass.run();
  const std::vector<uint32_t> values = fetch_samples(device, image, samples);
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    for (uint32_t s = 0; s < samples; ++s) {
      const Location at = standard_locations(samples)[s];
      const Side side = side_of(t, static_cast<int>(i % kSize) * 16 + at.x, static_cast<int>(i / kSize) * 16 + at.y);
      if (side == Side::kOnEdge) continue;
      const bool want = side == Side::kInside && (mask >> s & 1), got = values[i * samples + s] != 0;
      expect(want == got, fmt::format("pixel {}, {}, sample {} is {}", i % kSize, i / kSize, s, got ? "covered" : "not covered"));
    }
  }
}

// The mean of the samples, rounded to a step.
void run_resolve(Device& device, uint32_t samples, bool by_command) {
  require_samples(device, samples);
  require(!by_command || samples > 1, "more than one sample");
  Random random(fmt::format("resolve{}", samples));
  const Image image =
      create_target(device, samples, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
  const Image resolved =
      create_target(device, 1, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT);
  Target target;
  target.colours.push_back({&image, VK_ATTACHMENT_LOAD_OP_CLEAR, {.color = {{0.25f, 0.5f, 0.75f, 1.0f}}}});
  if (!by_command) target.resolves.push_back(&resolved);
  Pass pass(device, target);
  for (int i = 0; i < 6; ++i) {
    const std::string fragment =
        fmt::format("layout(location = 0) out vec4 c; void main() {{ c = vec4({}, {}, {}, 1.0) / 255.0; }}", random.below(256),
                    random.below(256), random.below(256));
    pass.add(triangle_state(random_triangle(random), samples, fragment.c_str()));
  }
  pass.run();
  if (by_command) {
    device.run([&](VkCommandBuffer commands) {
      transition(commands, resolved, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
      VkImageResolve region{};
      region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
      region.extent = {kSize, kSize, 1};
      vkCmdResolveImage(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, resolved.handle,
                        VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
      transition(commands, resolved, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    });
  }
  const auto means = download_as<uint8_t>(device, resolved, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const std::vector<uint32_t> values = fetch_samples(device, image, samples);
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    for (uint32_t c = 0; c < 4; ++c) {
      double sum = 0;
      for (uint32_t s = 0; s < samples; ++s) sum += values[i * samples + s] >> (8 * c) & 0xFF;
      expect(std::abs(means[i * 4 + c] - sum / samples) <= 1,
             fmt::format("pixel {}, channel {}: {}, not {}", i, c, means[i * 4 + c], sum / samples));
    }
  }
}

// Per-sample shading: gl_SampleID and gl_SamplePosition of each sample.
void run_sample_shading(Device& device, uint32_t samples) {
  require_samples(device, samples);
  require(device.caps().features.sampleRateShading, "sampleRateShading");
  const Image image = create_target(device, samples, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_SAMPLED_BIT);
  Target target;
  target.colours.push_back({&image, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  DrawState state;
  state.vertex = fullscreen_vertex();
  state.fragment = compile_glsl(
      VK_SHADER_STAGE_FRAGMENT_BIT,
      "layout(location = 0) out vec4 c; void main() { c = vec4(float(gl_SampleID), gl_SamplePosition * 16.0, 255.0) / 255.0; }");
  state.multisample.rasterizationSamples = static_cast<VkSampleCountFlagBits>(samples);
  Pass pass(device, target);
  pass.add(state);
  pass.run();
  const std::vector<uint32_t> values = fetch_samples(device, image, samples);
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    for (uint32_t s = 0; s < samples; ++s) {
      const Location at = standard_locations(samples)[s];
      const uint32_t value = values[i * samples + s];
      const uint32_t want = s | static_cast<uint32_t>(at.x) << 8 | static_cast<uint32_t>(at.y) << 16 | 0xFF000000u;
      expect(value == want, fmt::format("pixel {}, sample {}: {:#x}, not {:#x}", i, s, value, want));
    }
  }
}

// More alpha covers no fewer samples; none at 0, all at 1.
void run_alpha_to_coverage(Device& device, uint32_t samples) {
  require_samples(device, samples);
  const Image image = create_target(device, samples, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_SAMPLED_BIT);
  Target target;
  target.colours.push_back({&image, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  DrawState state;
  state.vertex = fullscreen_vertex();
  state.fragment =
      compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                   "layout(location = 0) out vec4 c; void main() { c = vec4(1.0, 1.0, 1.0, (gl_FragCoord.x - 0.5) / 15.0); }");
  state.multisample.rasterizationSamples = static_cast<VkSampleCountFlagBits>(samples);
  state.multisample.alphaToCoverageEnable = VK_TRUE;
  Pass pass(device, target);
  pass.add(state);
  pass.run();
  const std::vector<uint32_t> values = fetch_samples(device, image, samples);
  uint32_t columns[kSize] = {};
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    for (uint32_t s = 0; s < samples; ++s) columns[i % kSize] += values[i * samples + s] != 0;
  }
  expect(columns[0] == 0, fmt::format("alpha 0 covers {} samples", columns[0]));
  expect(columns[kSize - 1] == kSize * samples,
         fmt::format("alpha 1 covers {} of {} samples", columns[kSize - 1], kSize * samples));
  for (uint32_t x = 1; x < kSize; ++x)
    expect(columns[x] >= columns[x - 1], fmt::format("column {} has fewer samples than the one before", x));
}

}  // namespace

void register_multisample() {
  for (const uint32_t samples : {2u, 4u, 8u, 16u}) {
    const auto add = [&](const std::string& name, const char* section, std::function<void(Device&)> run) {
      add_case("pipeline.multisample", fmt::format("{}_samples.{}", samples, name), section, std::move(run));
    };
    for (uint32_t seed = 0; seed < 10; ++seed) {
      add(fmt::format("coverage.{}", seed), "27.3 Multisampling, standard sample locations",
          [=](Device& device) { run_coverage(device, samples, seed, ~0u); });
      add(fmt::format("mask.{}", seed), "28.3 Sample Mask Test",
          [=](Device& device) { run_coverage(device, samples, seed, 0x5A69u); });
    }
    add("resolve.attachment", "8.1 Render Pass Creation, resolve", [=](Device& device) { run_resolve(device, samples, false); });
    add("resolve.command", "20.7 Resolving Multisample Images", [=](Device& device) { run_resolve(device, samples, true); });
    add("sample_shading", "27.5 Sample Shading", [=](Device& device) { run_sample_shading(device, samples); });
    add("alpha_to_coverage", "28.5 Multisample Coverage", [=](Device& device) { run_alpha_to_coverage(device, samples); });
  }
}

}  // namespace pineda::cts
