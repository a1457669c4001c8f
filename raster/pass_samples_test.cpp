// Whole multisampled passes with hand-written kernels: no shortcut, tile size or number of threads may show.
#include <gtest/gtest.h>

#include <memory>

#include "base/sample_locations.h"
#include "raster/coverage.h"
#include "raster/test_scene.h"

namespace pineda::raster {
namespace {

using namespace testing;

constexpr uint32_t kWidth = 139, kHeight = 101;

// What the kernel below reads besides Constants: behind them in the push constants.
struct SampleConstants {
  uint32_t samples = 1;
  uint32_t equal_samples = 0;
};
SampleConstants sample_constants(const void* draw) {
  SampleConstants c;
  std::memcpy(&c, static_cast<const DrawContext*>(draw)->push_constants + sizeof(Constants), sizeof(c));
  return c;
}

uint32_t blended(uint32_t old, uint32_t color, uint32_t primitive) { return old * 5 + color * 77 + primitive * 31 + 1; }

// One colour for a pixel, mixed into that of each covered sample; a depth for the pixel, between those of the triangle's corners.
void sample_kernel(const KernelHandle*, const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
                   const void* waves) {
  const auto& t = *static_cast<const ThreadContext*>(thread);
  const Constants c = constants(draw);
  const auto [n, uses_equal] = sample_constants(draw);
  for (uint32_t p = 0; p < prim_count; ++p) {
    const auto& prim = *static_cast<const FragmentPrim*>(prims[p].prim);
    for (uint32_t i = 0; i < prims[p].wave_count; ++i) {
      const FragmentSampleWave& w = static_cast<const FragmentSampleWave*>(waves)[prims[p].first_wave + i];
      const uint32_t block = w.wave.block_index, full = (1u << n) - 1;
      auto* colors = reinterpret_cast<uint32_t*>(t.color[0]) + size_t{block} * n * kLanes;
      auto* depths = reinterpret_cast<float*>(t.depth) + size_t{block} * n * kLanes;
      uint32_t passed[kLanes];
      bool whole = true;
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        const Barycentrics b = barycentrics(prim, w.wave.x_px + morton_x(lane), w.wave.y_px + morton_y(lane));
        const float z1 = prim.z0 + prim.dz1, z2 = prim.z0 + prim.dz2;
        const float z = std::clamp(b.z, std::min({prim.z0, z1, z2}), std::max({prim.z0, z1, z2}));
        passed[lane] = 0;
        for (uint32_t s = 0; s < n; ++s) {
          if (!(w.samples[lane] >> s & 1)) continue;
          float& stored = depths[s * kLanes + lane];
          if (c.depth_test && !passes(c.compare, z, stored)) continue;
          if (c.depth_test && c.depth_write) stored = z;
          passed[lane] |= 1u << s;
        }
        whole &= passed[lane] == 0 || passed[lane] == full;
      }
      if (uses_equal && t.equal_samples[block] && !whole) {
        for (uint32_t s = 1; s < n; ++s) std::copy_n(colors, kLanes, colors + s * kLanes);
        t.equal_samples[block] = 0;
      }
      const uint32_t planes = uses_equal && t.equal_samples[block] ? 1 : n;
      for (uint32_t s = 0; s < planes; ++s) {
        for (uint32_t lane = 0; lane < kLanes; ++lane) {
          if (passed[lane] >> s & 1) colors[s * kLanes + lane] = blended(colors[s * kLanes + lane], c.color, prim.primitive_id);
        }
      }
    }
  }
}

// The same for each sample.
void per_sample_kernel(const KernelHandle*, const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
                       const void* waves) {
  const Constants c = constants(draw);
  for_fragments(thread, prims, prim_count, waves, [&](const FragmentPrim& prim, uint32_t* color, float*, uint32_t, uint32_t) {
    *color = blended(*color, c.color, prim.primitive_id);
  });
}

// The largest of a pixel's samples: of equal ones, any.
void resolve_kernel(const KernelHandle* self, const void*, void* thread, const PrimRecord* prims, uint32_t, const void* waves) {
  const auto& t = *static_cast<const ThreadContext*>(thread);
  const auto n = static_cast<uint32_t>(reinterpret_cast<uintptr_t>(self->self));
  for (uint32_t i = 0; i < prims[0].wave_count; ++i) {
    const uint32_t block = static_cast<const FragmentWave*>(waves)[i].block_index;
    const auto* from = reinterpret_cast<const uint32_t*>(t.color[0]) + size_t{block} * n * kLanes;
    auto* to = reinterpret_cast<uint32_t*>(t.color[1]) + size_t{block} * kLanes;
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      to[lane] = from[lane];
      for (uint32_t s = 1; s < n; ++s) to[lane] = std::max(to[lane], from[s * kLanes + lane]);
    }
  }
}

struct Result {
  std::vector<uint32_t> color, resolved;
  std::vector<float> depth;
  bool operator==(const Result&) const = default;
};

class SampleScene {
 public:
  explicit SampleScene(uint32_t samples) : samples_(samples) {
    std::mt19937 rng(samples);
    std::uniform_real_distribution<float> unit(0, 1), around(-1.2f, 1.2f);
    for (uint32_t d = 0; d < 8; ++d) {
      auto draw = std::make_unique<TestDraw>(4, d == 5 ? per_sample_kernel : sample_kernel);
      draw->constants.color = d;
      draw->constants.depth_test = d % 4 != 3 && d != 5;
      draw->constants.depth_write = d % 3 != 1;
      draw->constants.compare = d == 6 ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_LESS;
      draw->packet_base.per_sample = d == 5;
      const float size = d % 3 == 0 ? 2.5f : d % 2 ? 0.3f : 0.03f;
      for (uint32_t t = 0; t < 60; ++t) {
        const float cx = around(rng), cy = around(rng), cz = unit(rng) * 0.8f;
        for (int k = 0; k < 3; ++k)
          draw->add({cx + size * (unit(rng) - 0.5f), cy + size * (unit(rng) - 0.5f), cz + 0.2f * unit(rng), 1});
      }
      draws_.push_back(std::move(draw));
    }
  }

  Result render(const Options& options, uint32_t threads, VkAttachmentLoadOp load) {
    const size_t pixels = size_t{kWidth} * kHeight;
    Result out{std::vector<uint32_t>(pixels * samples_, 3), std::vector<uint32_t>(pixels),
               std::vector<float>(pixels * samples_, 1)};
    PassDesc desc;
    desc.extent = {kWidth, kHeight};
    desc.render_area.extent = desc.extent;
    desc.samples = samples_;
    desc.color_count = 1;
    Attachment& color = desc.color[0];
    color = {
        .address = reinterpret_cast<uint8_t*>(out.color.data()), .row_pitch_bytes = kWidth * 4, .format = VK_FORMAT_R32_UINT};
    color.load = load;
    color.clear.color.uint32[0] = 9;
    color.sample_pitch_bytes = pixels * 4;
    color.resolve = {resolve_kernel, reinterpret_cast<const void*>(uintptr_t{samples_})};
    color.resolve_address = reinterpret_cast<uint8_t*>(out.resolved.data());
    color.resolve_row_pitch_bytes = kWidth * 4;
    desc.depth = {
        .address = reinterpret_cast<uint8_t*>(out.depth.data()), .row_pitch_bytes = kWidth * 4, .format = VK_FORMAT_D32_SFLOAT};
    desc.depth.load = load;
    desc.depth.clear.depthStencil.depth = 0.7f;
    desc.depth.sample_pitch_bytes = pixels * 4;
    ThreadPool pool(threads);
    Pass pass(pool, desc, options);
    const SampleConstants extra{samples_, options.equal_samples};
    for (size_t i = 0; i < draws_.size(); ++i) {
      const DrawPacket packet = draws_[i]->packet(kWidth, kHeight);
      std::memcpy(draws_[i]->context.push_constants + sizeof(Constants), &extra, sizeof(extra));
      pass.draw(packet);
      if (i == 3) {
        VkClearValue value{};
        value.color.uint32[0] = 1234;
        const VkRect2D rects[] = {{{10, 20}, {60, 55}}};
        pass.clear(0, value, rects);
      }
    }
    pass.end();
    return out;
  }

 private:
  const uint32_t samples_;
  std::vector<std::unique_ptr<TestDraw>> draws_;
};

TEST(PassSamples, NothingButTheSceneDecidesTheBits) {
  for (const uint32_t samples : {2u, 4u, 8u, 16u}) {
    SampleScene scene(samples);
    for (const VkAttachmentLoadOp load : {VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_LOAD_OP_LOAD}) {
      Options plain = test_options();
      plain.tile_px = 16;
      plain.hi_z = plain.fast_clear = plain.opaque = plain.equal_samples = false;
      plain.isa = Isa::kSse42;
      const Result want = scene.render(plain, 1, load);
      for (const uint32_t threads : {1u, 3u}) {
        for (const uint32_t tile : {16u, 64u}) {
          for (const bool shortcuts : {false, true}) {
            for (const size_t budget : {size_t{1}, size_t{64} << 20}) {
              Options options = test_options();
              options.tile_px = tile;
              options.hi_z = options.fast_clear = options.opaque = options.equal_samples = shortcuts;
              options.bin_budget_bytes = budget;
              options.chunk_prims = budget == 1 ? 37 : 4096;
              const Result got = scene.render(options, threads, load);
              ASSERT_TRUE(got.color == want.color && got.resolved == want.resolved && got.depth == want.depth)
                  << samples << " samples, threads " << threads << " tile " << tile << " shortcuts " << shortcuts;
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace pineda::raster
