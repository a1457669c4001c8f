// For the rasterizer's tests: hand-written kernels with the signature of compiled ones, and a small target to draw to.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include "raster/options.h"
#include "raster/raster.h"

namespace pineda::raster::testing {

// ---- kernels --------------------------------------------------------------------------------------------------------------

// What the kernels below read of a draw: in DrawContext::push_constants.
struct Constants {
  uint32_t slots = 4;  // per vertex
  uint32_t color = 0;
  uint32_t depth_test = 0, depth_write = 0;
  float depth_max = 1e30f;  // depths are clamped to it
  VkCompareOp compare = VK_COMPARE_OP_ALWAYS;
};
inline Constants constants(const void* draw) {
  Constants c;
  std::memcpy(&c, static_cast<const DrawContext*>(draw)->push_constants, sizeof(c));
  return c;
}

// Copies vertex `index` of binding 0 (slots x f32); beyond the end: zeros. Instance i moves clip x by i * w / 8.
inline void vertex_kernel(const KernelHandle*, const void* draw, void*, const PrimRecord* prims, uint32_t prim_count,
                          const void* waves) {
  const auto& context = *static_cast<const DrawContext*>(draw);
  const uint32_t slots = constants(draw).slots;
  const auto& binding = context.vertex_buffers[0];
  const auto* data = reinterpret_cast<const float*>(binding.address);
  for (uint32_t p = 0; p < prim_count; ++p) {
    for (uint32_t i = 0; i < prims[p].wave_count; ++i) {
      const VertexWave& wave = static_cast<const VertexWave*>(waves)[prims[p].first_wave + i];
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        if (!(wave.mask >> lane & 1)) continue;
        const uint64_t first = uint64_t{wave.vertex_index[lane]} * slots;
        const bool inside = (first + slots) * 4 <= binding.size_bytes;
        for (uint32_t s = 0; s < slots; ++s) wave.out[s * kLanes + lane] = inside ? data[first + s] : 0.0f;
        wave.out[lane] += static_cast<float>(wave.instance_index[lane]) * wave.out[3 * kLanes + lane] * 0.125f;
      }
    }
  }
}

// Calls body(prim, context, texel of attachment 0 (u32), texel of depth (f32) or null, x, y) for covered lanes.
template <class Body>
inline void for_fragments(void* thread, const PrimRecord* prims, uint32_t prim_count, const void* waves, const Body& body) {
  const auto& t = *static_cast<const ThreadContext*>(thread);
  for (uint32_t p = 0; p < prim_count; ++p) {
    const auto& prim = *static_cast<const FragmentPrim*>(prims[p].prim);
    for (uint32_t i = 0; i < prims[p].wave_count; ++i) {
      const FragmentWave& wave = static_cast<const FragmentWave*>(waves)[prims[p].first_wave + i];
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        if (!(wave.coverage >> lane & 1)) continue;
        const uint32_t q = lane >> 2;
        const uint32_t x = wave.x_px + (lane & 1) + 2 * (q & 1), y = wave.y_px + (lane >> 1 & 1) + 2 * (q >> 1);
        const uint32_t texel = wave.block_index * kLanes + lane;
        body(prim, t.color[0] ? reinterpret_cast<uint32_t*>(t.color[0]) + texel : nullptr,
             t.depth ? reinterpret_cast<float*>(t.depth) + texel : nullptr, x, y);
      }
    }
  }
}

// attachment 0 += 1
inline void count_kernel(const KernelHandle*, const void*, void* thread, const PrimRecord* prims, uint32_t count,
                         const void* waves) {
  for_fragments(thread, prims, count, waves, [](const FragmentPrim&, uint32_t* color, float*, uint32_t, uint32_t) { ++*color; });
}

struct Barycentrics {
  float l1, l2, z, w, b_other, b2;
  bool flat;  // b_other is of vertex 1, not of vertex 0
};
inline Barycentrics barycentrics(const FragmentPrim& p, uint32_t x, uint32_t y) {  // the formulas of base/abi.h
  const float dx = static_cast<float>(x) + 0.5f - p.x0_px, dy = static_cast<float>(y) + 0.5f - p.y0_px;
  Barycentrics b;
  b.l1 = p.l1_dx * dx + p.l1_dy * dy;
  b.l2 = p.l2_dx * dx + p.l2_dy * dy;
  b.z = p.z0 + b.l1 * p.dz1 + b.l2 * p.dz2;
  b.w = 1 / (p.iw0 + b.l1 * (p.iw1 - p.iw0) + b.l2 * (p.iw2 - p.iw0));
  b.flat = p.iw0 == p.iw1 && p.iw0 == p.iw2;
  b.b_other = b.flat ? b.l1 * p.iw1 * b.w : (1 - b.l1 - b.l2) * p.iw0 * b.w;
  b.b2 = b.l2 * p.iw2 * b.w;
  return b;
}
inline float attribute(const FragmentPrim& p, const Barycentrics& b, uint32_t slot) {
  const uint32_t at = slot * kLanes;
  const float base = p.vertex[b.flat ? 0 : 1][at], other = p.vertex[b.flat ? 1 : 0][at];
  return base + b.b_other * (other - base) + b.b2 * (p.vertex[2][at] - base);
}
inline float flat_attribute(const FragmentPrim& p, uint32_t slot) {
  return *reinterpret_cast<const float*>(reinterpret_cast<const char*>(p.vertex[0] + slot * kLanes) + p.flat_offset_bytes);
}

inline bool passes(VkCompareOp op, float z, float stored) {
  switch (op) {
    case VK_COMPARE_OP_NEVER:
      return false;
    case VK_COMPARE_OP_LESS:
      return z < stored;
    case VK_COMPARE_OP_EQUAL:
      return z == stored;
    case VK_COMPARE_OP_LESS_OR_EQUAL:
      return z <= stored;
    case VK_COMPARE_OP_GREATER:
      return z > stored;
    case VK_COMPARE_OP_NOT_EQUAL:
      return z != stored;
    case VK_COMPARE_OP_GREATER_OR_EQUAL:
      return z >= stored;
    default:
      return true;
  }
}

// Depth test as the constants say; a fragment that passes mixes everything it knows into attachment 0, in a way that shows the
// order of fragments.
inline void mix_kernel(const KernelHandle*, const void* draw, void* thread, const PrimRecord* prims, uint32_t count,
                       const void* waves) {
  const Constants c = constants(draw);
  for_fragments(thread, prims, count, waves, [&](const FragmentPrim& p, uint32_t* color, float* depth, uint32_t x, uint32_t y) {
    const Barycentrics b = barycentrics(p, x, y);
    if (c.depth_test && depth) {
      const float z = std::min(b.z, c.depth_max);
      if (!passes(c.compare, z, *depth)) return;
      if (c.depth_write) *depth = z;
    }
    const auto bits = [](float f) {
      uint32_t u;
      std::memcpy(&u, &f, 4);
      return u;
    };
    uint32_t h = *color * 0x9E3779B1u + c.color + p.primitive_id * 7 + p.front_facing;
    h = (h ^ bits(b.l1)) * 0x85EBCA6Bu + bits(b.w);
    if (c.slots > 4) h = (h ^ bits(attribute(p, b, 4))) * 0xC2B2AE35u + bits(flat_attribute(p, 4));
    *color = h ^ h >> 15;
  });
}

// attachment 0 = constant colour
inline void color_kernel(const KernelHandle*, const void* draw, void* thread, const PrimRecord* prims, uint32_t count,
                         const void* waves) {
  const uint32_t value = constants(draw).color;
  for_fragments(thread, prims, count, waves,
                [&](const FragmentPrim&, uint32_t* color, float*, uint32_t, uint32_t) { *color = value; });
}

// ---- a scene --------------------------------------------------------------------------------------------------------------

struct Target {
  uint32_t width, height;
  std::vector<uint32_t> color;
  std::vector<float> depth;
  explicit Target(uint32_t w, uint32_t h) : width(w), height(h), color(size_t{w} * h, 0), depth(size_t{w} * h, 1.0f) {}
  uint32_t at(uint32_t x, uint32_t y) const { return color[size_t{y} * width + x]; }

  PassDesc desc(bool with_depth = false) {
    PassDesc d;
    d.extent = {width, height};
    d.render_area = {{0, 0}, {width, height}};
    d.color_count = 1;
    d.color[0] = {reinterpret_cast<uint8_t*>(color.data()), width * 4, VK_FORMAT_R8G8B8A8_UNORM};
    if (with_depth) d.depth = {reinterpret_cast<uint8_t*>(depth.data()), width * 4, VK_FORMAT_D32_SFLOAT};
    return d;
  }
};

// A draw with its own vertices. Must not move once packet() was used.
struct TestDraw {
  std::vector<float> vertices;  // slots each
  DrawContext context{};
  Constants constants;
  DrawPacket packet_base;

  explicit TestDraw(uint32_t slots, KernelFn fragment) {
    constants.slots = slots;
    packet_base.vertex = {vertex_kernel, nullptr};
    packet_base.fragment = {fragment, nullptr};
    packet_base.vertex_slots = slots;
  }
  uint32_t vertex_count() const { return static_cast<uint32_t>(vertices.size()) / constants.slots; }
  void add(std::initializer_list<float> vertex) { vertices.insert(vertices.end(), vertex); }

  // Full-target viewport and scissor.
  DrawPacket packet(uint32_t width, uint32_t height) {
    std::memcpy(context.push_constants, &constants, sizeof(constants));
    context.vertex_buffers[0] = {reinterpret_cast<uint64_t>(vertices.data()), static_cast<uint32_t>(vertices.size() * 4), 0};
    DrawPacket p = packet_base;
    p.context = &context;
    if (p.count == 0) p.count = vertex_count();
    if (p.viewport.width == 0) p.viewport = {0, 0, static_cast<float>(width), static_cast<float>(height), 0, 1};
    if (p.scissor.extent.width == 0) p.scissor = {{0, 0}, {width, height}};
    p.depth_test = constants.depth_test != 0;
    p.depth_write = constants.depth_write != 0;
    p.depth_compare = constants.compare;
    p.early_depth = true;
    return p;
  }
};

// A vertex at window position (x, y) px of a width x height viewport. Exact for multiples of 1/256 px when the sizes are powers
// of two.
inline void add_window_vertex(TestDraw& draw, uint32_t width, uint32_t height, float x, float y, float z = 0.5f, float w = 1.0f) {
  const float xn = x / (static_cast<float>(width) * 0.5f) - 1, yn = y / (static_cast<float>(height) * 0.5f) - 1;
  draw.add({xn * w, yn * w, z * w, w});
}

inline Options test_options() {
  Options options;
  options.isa = best_isa();
  return options;
}

}  // namespace pineda::raster::testing
