#include "compiler/kernels/sample_call.h"

#include "base/abi.h"
#include "compiler/kernels/sample_lod.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;
using spirv::LodMode;
using spirv::SampleRequest;
using Operation = SampleSignature::Operation;

// Bit fields of the packed form, low bits first.
class Packer {
 public:
  void put(uint64_t value, uint32_t bits) {
    word_ |= (value & ((uint64_t{1} << bits) - 1)) << at_;
    at_ += bits;
  }
  uint64_t word() const { return word_; }

 private:
  uint64_t word_ = 0;
  uint32_t at_ = 0;
};

class Unpacker {
 public:
  explicit Unpacker(uint64_t word) : word_(word) {}
  uint32_t get(uint32_t bits) {
    const auto value = static_cast<uint32_t>(word_ & ((uint64_t{1} << bits) - 1));
    word_ >>= bits;
    return value;
  }

 private:
  uint64_t word_;
};

ir::Address row_address(Builder& b, Value record, uint32_t first_byte, uint32_t row) {
  return {.base = record, .offset = b.i32(first_byte + row * kVertexSlotBytes), .lane_stride = 4};
}
ir::Address argument_row(Builder& b, Value record, uint32_t row) {
  return row_address(b, record, offsetof(SampleCall, argument), row);
}
ir::Address result_row(Builder& b, Value record, uint32_t row) {
  return row_address(b, record, offsetof(SampleCall, result), row);
}

// Every argument that the signature names, with its row and type: the one list for both sides.
template <typename Fn>
void for_each_argument(const SampleSignature& s, SampleRequest& r, Fn&& fn) {
  const uint32_t axes = axis_count(s.view_type);
  const bool fetch = s.operation == Operation::kFetch;
  for (uint32_t i = 0; i < axes + (is_array(s.view_type) ? 1 : 0); ++i) {
    fn(r.coord[i], kRowCoord + i, fetch ? Type::kI32 : Type::kF32);
  }
  if (fetch || s.lod_mode == LodMode::kExplicit) fn(r.lod, kRowLod, fetch ? Type::kI32 : Type::kF32);
  if (s.lod_mode == LodMode::kGradient) {
    for (uint32_t i = 0; i < axes; ++i) {
      fn(r.ddx[i], kRowDdx + i, Type::kF32);
      fn(r.ddy[i], kRowDdy + i, Type::kF32);
    }
    if (s.has_bias) fn(r.bias, kRowLod, Type::kF32);  // in the place of the explicit LOD
  }
  if (s.has_min_lod) fn(r.min_lod, kRowMinLod, Type::kF32);
  if (s.has_reference) fn(r.depth_reference, kRowReference, Type::kF32);
  if (s.has_sample) fn(r.sample, kRowSample, Type::kI32);
  for (uint32_t i = 0; i < axes && s.has_dynamic_offset; ++i) fn(r.dynamic_offset[i], kRowOffset + i, Type::kI32);
}

Channels call(Builder& b, Value image, Value sampler, const SampleSignature& signature, SampleRequest request) {
  const Value record = b.ptr_add(b.thread_ptr(), b.i32(offsetof(ThreadContext, sample_call)));
  const auto field = [&](size_t offset_bytes) {
    return ir::Address{.base = record, .offset = b.i32(static_cast<uint32_t>(offset_bytes))};
  };
  b.store(field(offsetof(SampleCall, mask)), b.ballot(b.b1(true)));
  b.store(field(offsetof(SampleCall, signature)), b.i64(signature.pack()));
  const auto descriptor_row = [&](size_t offset_bytes, Value descriptor) {
    ir::Address at = field(offset_bytes);
    at.lane_stride = 8;
    b.store(at, descriptor);
  };
  descriptor_row(offsetof(SampleCall, image_of_lane), image);
  descriptor_row(offsetof(SampleCall, sampler_of_lane), sampler);
  for_each_argument(signature, request, [&](Value& v, uint32_t row, Type) { b.store(argument_row(b, record, row), v); });
  b.call(load_draw(b, Type::kPtr, offsetof(DrawContext, sample)), record, sizeof(SampleCall));
  Channels out{};
  for (uint32_t c = 0; c < 4; ++c) {
    out[c] = b.load(signature.integer ? Type::kI32 : Type::kF32, result_row(b, record, c));
  }
  return out;
}

}  // namespace

uint64_t SampleSignature::pack() const {
  Packer p;
  p.put(static_cast<uint64_t>(operation), 2);
  p.put(static_cast<uint64_t>(view_type), 3);
  p.put(static_cast<uint64_t>(lod_mode), 2);
  for (const bool flag : {integer, has_bias, has_min_lod, has_reference, has_dynamic_offset, has_sample}) p.put(flag, 1);
  p.put(static_cast<uint64_t>(gather_component + 1), 3);
  for (const int32_t o : offset) p.put(static_cast<uint64_t>(o), 8);
  return p.word();
}

SampleSignature SampleSignature::unpack(uint64_t bits) {
  Unpacker u(bits);
  SampleSignature s;
  s.operation = static_cast<Operation>(u.get(2));
  s.view_type = static_cast<VkImageViewType>(u.get(3));
  s.lod_mode = static_cast<LodMode>(u.get(2));
  for (bool* flag : {&s.integer, &s.has_bias, &s.has_min_lod, &s.has_reference, &s.has_dynamic_offset, &s.has_sample}) {
    *flag = u.get(1) != 0;
  }
  s.gather_component = static_cast<int8_t>(static_cast<int>(u.get(3)) - 1);
  for (int32_t& o : s.offset) o = static_cast<int8_t>(u.get(8));
  return s;
}

Result<Channels> call_sample(Builder& b, Value image, Value sampler, const SampleRequest& request) {
  if (ir::size_bytes(request.result) != 4) return compile_error("Only 32-bit sampling results are supported.");
  const SampleRequest r = with_gradients(b, request, axis_count(request.view_type));
  SampleSignature s{.operation = r.lod_mode == LodMode::kFetch ? Operation::kFetch : Operation::kSample,
                    .view_type = r.view_type,
                    .lod_mode = r.lod_mode,
                    .integer = r.result == Type::kI32,
                    .has_bias = static_cast<bool>(r.bias),
                    .has_min_lod = static_cast<bool>(r.min_lod),
                    .has_reference = static_cast<bool>(r.depth_reference),
                    .has_dynamic_offset = static_cast<bool>(r.dynamic_offset[0]),
                    .has_sample = static_cast<bool>(r.sample),
                    .gather_component = static_cast<int8_t>(r.gather_component),
                    .offset = r.offset};
  for (const int32_t o : r.offset) {
    if (o < INT8_MIN || o > INT8_MAX) return compile_error("A texel offset is beyond the limits.");
  }
  return call(b, image, sampler, s, r);
}

Result<Channels> call_query_lod(Builder& b, Value image, Value sampler, const spirv::ImageQuery& query) {
  const SampleRequest r = lod_request(b, query);
  const SampleSignature s{.operation = Operation::kQueryLod, .view_type = query.view_type, .lod_mode = LodMode::kGradient};
  return call(b, image, sampler, s, r);
}

Result<ir::Kernel> build_sample_function(const compiler::TextureState& state, const SampleSignature& s) {
  ir::Kernel kernel{.name = "sample", .kind = ir::KernelKind::kCompute, .wave_stride_bytes = sizeof(SampleCall)};
  Builder b(kernel);
  const Value record = b.wave_ptr();
  const auto descriptor = [&](size_t offset_bytes) {
    return b.load(Type::kPtr, record, static_cast<uint32_t>(offset_bytes), kFixed);
  };
  const SampleSource source{state, descriptor(offsetof(SampleCall, image)), descriptor(offsetof(SampleCall, sampler))};
  SampleRequest r;
  for_each_argument(s, r, [&](Value& v, uint32_t row, Type type) { v = b.load(type, argument_row(b, record, row)); });
  r.view_type = s.view_type;
  r.result = s.integer ? Type::kI32 : Type::kF32;
  r.lod_mode = s.lod_mode;
  r.offset = s.offset;
  r.gather_component = s.gather_component;
  Result<Channels> texel;
  if (s.operation == Operation::kQueryLod) {
    texel = query_lod(b, source, r);
  } else {
    texel = sample_image(b, source, r);
  }
  if (!texel) return std::unexpected(texel.error());
  for (uint32_t c = 0; c < 4; ++c) b.store(result_row(b, record, c), (*texel)[c]);
  return kernel;
}

}  // namespace pineda::kernels
