// Compute kernel: one wave is 16 consecutive invocations of a workgroup.
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
    const Value first = b.load(Type::kI32, b.wave_ptr(), offsetof(ComputeWave, first_invocation), kFixed);
    local_index_ = b.iadd(first, b.lane());
  }

  Value input(Builder& b, const spirv::InterfaceScalar& in) override {
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
      default:
        return {};
    }
  }

  void output(Builder&, const spirv::InterfaceScalar&, Value) override {}

  Value shared_memory(Builder& b) override {
    return b.load(Type::kPtr, b.prim_ptr(), offsetof(WorkgroupRecord, shared_memory), kFixed);
  }

 private:
  static Value workgroup_id(Builder& b, uint32_t axis) {
    return b.load(Type::kI32, b.prim_ptr(), static_cast<uint32_t>(offsetof(WorkgroupRecord, id) + 4 * axis), kFixed);
  }

  static bool is_power_of_two(uint32_t x) { return (x & (x - 1)) == 0; }

  static Value divide(Builder& b, Value x, uint32_t y) {
    return is_power_of_two(y) ? b.lshr(x, b.i32(static_cast<uint32_t>(__builtin_ctz(y)))) : b.udiv(x, b.i32(y));
  }

  static Value remainder(Builder& b, Value x, uint32_t y) {
    return is_power_of_two(y) ? b.and_(x, b.i32(y - 1)) : b.urem(x, b.i32(y));
  }

  // local_index = x + size.x * (y + size.y * z); axes of extent one cost nothing.
  Value local_id(Builder& b, uint32_t axis) const {
    if (local_size_[axis] == 1) return b.i32(0);
    uint32_t below = 1, above = 1;
    for (uint32_t a = 0; a < axis; ++a) below *= local_size_[a];
    for (uint32_t a = axis + 1; a < 3; ++a) above *= local_size_[a];
    const Value rest = divide(b, local_index_, below);
    return above == 1 ? rest : remainder(b, rest, local_size_[axis]);
  }

  const std::array<uint32_t, 3> local_size_;
  Value local_index_;
};

}  // namespace

Result<ir::Kernel> build_compute(const compiler::ComputeSource& source, const Shader& shader) {
  for (const uint32_t extent : shader.info.local_size) {
    if (extent == 0) return compile_error("The workgroup size has an extent of zero.");
  }
  ir::Kernel kernel{.name = source.name + ".compute", .kind = ir::KernelKind::kCompute, .wave_stride_bytes = sizeof(ComputeWave)};
  Builder b(kernel);
  ComputeStage stage(b, source, shader.info.local_size);
  const Result<spirv::Translation> done = shader.body(b, stage);
  if (!done) return explain(done.error(), stage);
  return kernel;
}

}  // namespace pineda::kernels
