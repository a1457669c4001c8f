#include "raster/vertex_batch.h"

#include <cfloat>

#if defined(__x86_64__)
#include <immintrin.h>
#else
#error "the host float code has an x86-64 implementation only"
#endif

#include "raster/assemble.h"

namespace pineda::raster {
namespace {

// Bits of `code` where the mask of a comparison is set.
inline __m128i code_where(__m128 mask, int code) { return _mm_and_si128(_mm_castps_si128(mask), _mm_set1_epi32(code)); }

inline __m128 is_finite(__m128 v) {
  const __m128 magnitude = _mm_andnot_ps(_mm_set1_ps(-0.0f), v);
  return _mm_cmple_ps(magnitude, _mm_set1_ps(FLT_MAX));  // false for infinities and NaN
}

inline __m128i outside_fixed_point(__m128i v) {
  return _mm_or_si128(_mm_cmpgt_epi32(v, _mm_set1_epi32(kMaxFx8)), _mm_cmplt_epi32(v, _mm_set1_epi32(kMinFx8)));
}

// Four vertices. Returns their codes, one in each 32-bit element.
inline __m128i transform_four(const ViewportTransform& t, const float* p, WindowVertices& out, uint32_t i) {
  const __m128 x = _mm_load_ps(p), y = _mm_load_ps(p + kLanes), z = _mm_load_ps(p + 2 * kLanes), w = _mm_load_ps(p + 3 * kLanes);
  const __m128 finite = _mm_and_ps(_mm_and_ps(is_finite(x), is_finite(y)), _mm_and_ps(is_finite(z), is_finite(w)));
  __m128i code = code_where(_mm_cmplt_ps(w, _mm_set1_ps(kMinW)), kClipW);
  if (t.clip_depth) {
    code = _mm_or_si128(code, code_where(_mm_cmplt_ps(z, _mm_setzero_ps()), kClipNear));
    code = _mm_or_si128(code, code_where(_mm_cmpgt_ps(z, w), kClipFar));
  }
  code = _mm_or_si128(code, code_where(_mm_cmplt_ps(x, _mm_mul_ps(_mm_set1_ps(t.guard_x_min), w)), kClipLeft));
  code = _mm_or_si128(code, code_where(_mm_cmpgt_ps(x, _mm_mul_ps(_mm_set1_ps(t.guard_x_max), w)), kClipRight));
  code = _mm_or_si128(code, code_where(_mm_cmplt_ps(y, _mm_mul_ps(_mm_set1_ps(t.guard_y_min), w)), kClipTop));
  code = _mm_or_si128(code, code_where(_mm_cmpgt_ps(y, _mm_mul_ps(_mm_set1_ps(t.guard_y_max), w)), kClipBottom));

  const __m128 xd = _mm_div_ps(x, w), yd = _mm_div_ps(y, w), zd = _mm_div_ps(z, w);
  // Scaling by 256 is exact, so this rounds like the transform to pixels; the conversion rounds to nearest even.
  const __m128i xf = _mm_cvtps_epi32(_mm_add_ps(_mm_mul_ps(_mm_set1_ps(t.scale_x_fx8), xd), _mm_set1_ps(t.offset_x_fx8)));
  const __m128i yf = _mm_cvtps_epi32(_mm_add_ps(_mm_mul_ps(_mm_set1_ps(t.scale_y_fx8), yd), _mm_set1_ps(t.offset_y_fx8)));
  const __m128 zf = _mm_add_ps(_mm_mul_ps(_mm_set1_ps(t.scale_z), zd), _mm_set1_ps(t.offset_z));
  _mm_store_si128(reinterpret_cast<__m128i*>(out.x_fx8 + i), xf);
  _mm_store_si128(reinterpret_cast<__m128i*>(out.y_fx8 + i), yf);
  _mm_store_ps(out.z + i, zf);
  _mm_store_ps(out.iw + i, _mm_div_ps(_mm_set1_ps(1.0f), w));

  // A vertex inside all planes must fit fixed point (an odd viewport could break that); clipped ones get new coordinates.
  const __m128i inside = _mm_cmpeq_epi32(code, _mm_setzero_si128());
  __m128i drop = _mm_and_si128(inside, _mm_or_si128(outside_fixed_point(xf), outside_fixed_point(yf)));
  drop = _mm_or_si128(drop, _mm_andnot_si128(_mm_castps_si128(is_finite(zf)), inside));
  drop = _mm_or_si128(drop, _mm_andnot_si128(_mm_castps_si128(finite), _mm_set1_epi32(-1)));
  return _mm_or_si128(code, _mm_and_si128(drop, _mm_set1_epi32(kClipDrop)));
}

// Adds the bits of clip and cull distances of 16 vertices. NaN is outside.
void code_distances(const VertexOutputs& outputs, const float* wave, uint16_t* codes) {
  const auto add = [&](uint32_t slot, uint32_t bit) {
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      if (!(wave[slot * kLanes + lane] >= 0)) codes[lane] |= static_cast<uint16_t>(kClipDistances << bit);
    }
  };
  for (uint32_t i = 0; i < outputs.clip_count; ++i) add(outputs.clip_distance + i, i);
  for (uint32_t i = 0; i < outputs.cull_count; ++i) add(outputs.cull_distance + i, outputs.clip_count + i);
}

}  // namespace

void transform_wave(const ViewportTransform& viewport, const VertexOutputs& outputs, const float* wave, WindowVertices& out,
                    uint32_t first) {
  __m128i codes[4];
  for (uint32_t q = 0; q < 4; ++q) codes[q] = transform_four(viewport, wave + q * 4, out, first + q * 4);
  const __m128i low = _mm_packus_epi32(codes[0], codes[1]), high = _mm_packus_epi32(codes[2], codes[3]);
  _mm_store_si128(reinterpret_cast<__m128i*>(out.code + first), low);
  _mm_store_si128(reinterpret_cast<__m128i*>(out.code + first + 8), high);
  if (outputs.clip_count + outputs.cull_count != 0) [[unlikely]]
    code_distances(outputs, wave, out.code + first);
}

inline uint16_t VertexBatch::add_vertex(uint32_t index, uint32_t instance) {
  const uint32_t vertex = vertex_count_++;
  VertexWave& wave = waves_[vertex / kLanes];
  wave.vertex_index[vertex % kLanes] = index;
  wave.instance_index[vertex % kLanes] = instance;
  return static_cast<uint16_t>(vertex);
}

inline uint16_t VertexBatch::find_or_add(uint32_t index, uint32_t instance) {
  CacheEntry& entry = cache_[index % kCacheSize];
  if (entry.generation == generation_ && entry.index == index) return entry.vertex;
  const uint16_t vertex = add_vertex(index, instance);
  entry = {index, generation_, vertex};
  return vertex;
}

// Forgets all vertices: another batch or another instance begins.
void VertexBatch::next_generation() {
  if (++generation_ == 0) {
    for (CacheEntry& entry : cache_) entry.generation = 0;
    generation_ = 1;
  }
}

void VertexBatch::assemble_indexed_list(const Draw& draw, const IndexReader& reader, uint32_t instance, uint64_t first,
                                        uint32_t count, uint32_t out) {
  reader.read(uint64_t{draw.packet.first} + first * 3, count * 3, indices_);
  const auto offset = static_cast<uint32_t>(draw.packet.vertex_offset);
  for (uint32_t i = 0; i < count; ++i) {
    for (uint32_t k = 0; k < 3; ++k) prims_[out + i][k] = find_or_add(indices_[3 * i + k] + offset, instance);
  }
}

// Primitives [first, first + count) of one instance, into prims_[out ...].
void VertexBatch::assemble_run(const Draw& draw, uint32_t instance, uint64_t first, uint32_t count, uint32_t out) {
  const DrawPacket& packet = draw.packet;
  const IndexReader reader(packet.index);
  const bool list = find_topology(packet.topology)->is_list;
  if (packet.topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST && reader.indexed() && draw.restart_prims.empty() &&
      !packet.provoking_last) {
    assemble_indexed_list(draw, reader, instance, first, count, out);
    return;
  }
  const uint32_t n = vertices_of(draw.kind);
  for (uint32_t i = 0; i < count; ++i) {
    const auto p = static_cast<uint32_t>(first + i);
    const std::array<uint32_t, 3> v =
        draw.restart_prims.empty() ? primitive_vertices(packet.topology, packet.provoking_last, p) : draw.restart_prims[p].vertex;
    for (uint32_t k = 0; k < n; ++k) {
      if (reader.indexed()) {
        const uint32_t index = reader.read(uint64_t{packet.first} + v[k]) + static_cast<uint32_t>(packet.vertex_offset);
        prims_[out + i][k] = find_or_add(index, instance);
      } else {
        const uint32_t index = packet.first + v[k];
        prims_[out + i][k] = list ? add_vertex(index, instance) : find_or_add(index, instance);
      }
    }
  }
}

void VertexBatch::assemble(const Draw& draw, uint64_t first, uint32_t count) {
  vertex_count_ = 0;
  for (uint32_t done = 0; done < count;) {
    const uint64_t in_draw = first + done;
    const uint64_t in_instance = in_draw % draw.prims_per_instance;
    const auto n = static_cast<uint32_t>(std::min<uint64_t>(count - done, draw.prims_per_instance - in_instance));
    const uint32_t instance = draw.packet.first_instance + static_cast<uint32_t>(in_draw / draw.prims_per_instance);
    next_generation();
    assemble_run(draw, instance, in_instance, n, done);
    done += n;
  }
}

uint32_t VertexBatch::shade(const Draw& draw, uint64_t first, uint32_t count, Chunk& chunk, ThreadContext& context) {
  assemble(draw, first, count);
  const uint32_t wave_count = (vertex_count_ + kLanes - 1) / kLanes;
  const size_t wave_floats = size_t{draw.packet.vertex_slots} * kLanes;
  vertices_ = static_cast<float*>(chunk.vertices.allocate(wave_count * wave_floats * sizeof(float)));
  for (uint32_t i = 0; i < wave_count; ++i) {
    VertexWave& wave = waves_[i];
    const uint32_t lanes = std::min(kLanes, vertex_count_ - i * kLanes);
    wave.mask = (1u << lanes) - 1;
    wave.reserved = 0;
    wave.out = vertices_ + i * wave_floats;
    for (uint32_t lane = lanes; lane < kLanes;
         ++lane) {  // lanes without a vertex repeat the first, so that they read nothing new
      wave.vertex_index[lane] = wave.vertex_index[0];
      wave.instance_index[lane] = wave.instance_index[0];
    }
  }
  const PrimRecord record{nullptr, 0, wave_count};
  draw.packet.vertex(draw.packet.context, &context, &record, 1, waves_);
  for (uint32_t i = 0; i < wave_count; ++i)
    transform_wave(draw.viewport, draw.packet.outputs, vertices_ + i * wave_floats, window_, i * kLanes);
  return vertex_count_;
}

}  // namespace pineda::raster
