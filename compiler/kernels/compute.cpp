// Compute kernel: one wave is 16 consecutive invocations of a workgroup.
#include <algorithm>

#include "base/abi.h"
#include "compiler/kernels/kernels.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;
using spirv::BuiltIn;

class ComputeStage final : public Stage {
 public:
  ComputeStage(Builder& b, const compiler::ComputeSource& source, const std::array<uint32_t, 3>& local_size)
      : Stage(*source.layout, source.textures), local_size_(local_size) {
    // That ids are small is said by operations that change nothing, for who asks how large offsets get (ir/ranges.h).
    const Value first = b.load(Type::kI32, b.wave_ptr(), offsetof(ComputeWave, first_invocation), kFixed);
    const uint64_t count = uint64_t{local_size[0]} * local_size[1] * local_size[2];
    const auto last = static_cast<uint32_t>(std::min<uint64_t>(count, kMaxInvocations) - 1);
    const Value last_first = b.i32(last / kLanes * kLanes);
    first_ = is_power_of_two(last + 1) ? b.and_(first, last_first) : b.umin(first, last_first);
    local_index_ = b.iadd(first_, b.lane());
  }

  Value input(Builder& b, const spirv::InterfaceScalar& in) override {
    if (const Value common = common_input(b, in)) return common;
    if (!in.built_in || in.component > 2) return {};
    const uint32_t axis = in.component;
    switch (*in.built_in) {
      case BuiltIn::kLocalInvocationIndex:
        return local_index_;
      case BuiltIn::kLocalInvocationId:
        return local_id(b, axis);
      case BuiltIn::kWorkgroupId:
        return workgroup_id(b, axis);
      case BuiltIn::kNumWorkgroups:
        return load_draw(b, Type::kI32, offsetof(DrawContext, workgroup_count) + 4 * axis);
      case BuiltIn::kGlobalInvocationId:
        return b.iadd(b.imul(workgroup_id(b, axis), b.i32(local_size_[axis])), local_id(b, axis));
      case BuiltIn::kSubgroupId:
        return b.lshr(first_, b.i32(4));
      case BuiltIn::kNumSubgroups:
        return b.i32((local_size_[0] * local_size_[1] * local_size_[2] + kLanes - 1) / kLanes);
      default:
        return {};
    }
  }

  void output(Builder&, const spirv::InterfaceScalar&, Value) override {}

  Value shared_memory(Builder& b) override {
    return b.load(Type::kPtr, b.prim_ptr(), offsetof(WorkgroupRecord, shared_memory), kFixed);
  }

 private:
  static constexpr uint32_t kMaxInvocations = 1024, kMaxWorkgroup = 0xffff;  // icd/limits.cpp

  static Value workgroup_id(Builder& b, uint32_t axis) {
    const auto offset = static_cast<uint32_t>(offsetof(WorkgroupRecord, id) + 4 * axis);
    return b.and_(b.load(Type::kI32, b.prim_ptr(), offset, kFixed), b.i32(kMaxWorkgroup));
  }

  // first_invocation is a multiple of 16. Where waves are rows of the workgroup, or whole rows fill waves, each axis is the sum
  // of a uniform value and a constant vector, which makes y and z of a wide workgroup scalars, and addresses contiguous.
  static bool is_power_of_two(uint32_t x) { return (x & (x - 1)) == 0; }

  static Value divide(Builder& b, Value x, uint32_t y) {
    return is_power_of_two(y) ? b.lshr(x, b.i32(static_cast<uint32_t>(__builtin_ctz(y)))) : b.udiv(x, b.i32(y));
  }

  static Value remainder(Builder& b, Value x, uint32_t y) {
    return is_power_of_two(y) ? b.and_(x, b.i32(y - 1)) : b.urem(x, b.i32(y));
  }

  // Where in its row of `size_x` invocations a wave begins: a multiple of 16, as size_x is.
  Value row_part(Builder& b, uint32_t size_x) const {
    return is_power_of_two(size_x) ? b.and_(first_, b.i32(size_x - kLanes))
                                   : b.umin(b.urem(first_, b.i32(size_x)), b.i32(size_x - kLanes));
  }

  // local_index = x + size.x * (y + size.y * z); axes of extent one cost nothing.
  Value local_id(Builder& b, uint32_t axis) const {
    if (local_size_[axis] == 1) return b.i32(0);
    const uint32_t size_x = local_size_[0], size_y = local_size_[1], size_z = local_size_[2];
    const bool wide = size_x % kLanes == 0, narrow = kLanes % size_x == 0 && size_x * size_y % kLanes == 0;
    if (wide || narrow) {
      if (axis == 0) return wide ? b.iadd(row_part(b, size_x), b.lane()) : remainder(b, b.lane(), size_x);
      const Value row = divide(b, first_, size_x);
      if (axis == 2) return divide(b, row, size_y);
      const Value y = size_z == 1 ? row : remainder(b, row, size_y);
      return wide ? y : b.iadd(y, divide(b, b.lane(), size_x));
    }
    uint32_t below = 1, above = 1;
    for (uint32_t a = 0; a < axis; ++a) below *= local_size_[a];
    for (uint32_t a = axis + 1; a < 3; ++a) above *= local_size_[a];
    const Value rest = divide(b, local_index_, below);
    return above == 1 ? rest : remainder(b, rest, local_size_[axis]);
  }

  const std::array<uint32_t, 3> local_size_;
  Value first_, local_index_;
};

}  // namespace

Result<ir::Kernel> build_compute(const compiler::ComputeSource& source, const Shader& shader) {
  for (const uint32_t extent : shader.info.local_size) {
    if (extent == 0) return compile_error("The workgroup size has an extent of zero.");
  }
  ir::Kernel kernel{.name = source.name + ".compute", .kind = ir::KernelKind::kCompute, .wave_stride_bytes = sizeof(ComputeWave)};
  const auto& size = shader.info.local_size;
  kernel.full_waves = uint64_t{size[0]} * size[1] * size[2] % kLanes == 0;
  Builder b(kernel);
  ComputeStage stage(b, source, shader.info.local_size);
  const Result<spirv::Translation> done = shader.body(b, stage);
  if (!done) return explain(done.error(), stage);
  return kernel;
}

}  // namespace pineda::kernels
