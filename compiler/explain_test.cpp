// What explain counts of compute kernels, on kernels small enough to count by hand.
#include "compiler/explain.h"

#include <gtest/gtest.h>

#include "compiler/spirv/test_shaders.h"

namespace pineda::compiler {
namespace {

ComputeSizes measure_text(const std::string& wave) {
  const ir::ParseResult parsed = ir::parse("kernel compute \"t\" stride 8\nwave:\n" + wave);
  EXPECT_EQ(parsed.error, "") << wave;
  EXPECT_EQ(ir::verify(parsed.kernel), "") << wave;
  return measure_compute_kernel(parsed.kernel);
}

TEST(ExplainCompute, EachStepTakesWhatIsItsOwn) {
  const ComputeSizes sizes = measure_text(R"(%a = local i32 1
%p = prim_ptr ptr
%l = lane i32
%zero = const i32 0
%two = const i32 2
%four = const i32 4
%unused = imul i32 %l, %two
%six = iadd i32 %two, %four
local_store %a, %zero, %six
%kept = local_load i32 %a, %zero
%o = imul i32 %l, %four
%again = imul i32 %l, %four
%x = load i32 %p, %o
%y = load i32 %p, %again
%sum = iadd i32 %x, %y
%all = iadd i32 %sum, %kept
store %p, %o, %all
)");
  EXPECT_EQ(sizes.kernel.built, 17u);
  EXPECT_EQ(sizes.kernel.built_loads, 2u);
  EXPECT_EQ(sizes.kernel.built_stores, 1u);
  EXPECT_EQ(sizes.removed.variables, 1u);  // %a
  EXPECT_EQ(sizes.removed.accesses, 2u);   // %kept and what it loads
  EXPECT_EQ(sizes.removed.dead, 1u);       // %unused
  EXPECT_EQ(sizes.removed.constant, 1u);   // %six
  EXPECT_EQ(sizes.removed.equal, 2u);      // %again, %y
  EXPECT_EQ(sizes.removed.equal_loads, 1u);
  EXPECT_EQ(sizes.kernel.loads, 1u);
  EXPECT_EQ(sizes.kernel.stores, 1u);
  EXPECT_EQ(sizes.branches.built, 0u);
}

TEST(ExplainCompute, BoundsChecksByWhatDecidesThem) {
  const ComputeSizes sizes = measure_text(R"(%p = prim_ptr ptr
%w = wave_ptr ptr
%l = lane i32
%zero = const i32 0
%four = const i32 4
%sixty_four = const i32 64
%sixty = const i32 60
%size = load i32 %w, %zero
%o = imul i32 %l, %four
%in = load i32 %p, %o limit %sixty_four
%row = load i32 %p, %o limit %size
%index = imul i32 %row, %four
%gathered = load i32 %p, %index limit %size
%sum = iadd i32 %in, %gathered
store %p, %o, %sum limit %sixty
)");
  EXPECT_EQ(sizes.checks.built, 4u);
  EXPECT_EQ(sizes.checks.per_lane, 2u);  // %gathered; the store, of which the last lane is outside for certain
  EXPECT_EQ(sizes.checks.per_wave, 1u);  // %row
}

constexpr const char* kBarriers = R"(
  layout(local_size_x = 64) in; layout(constant_id = 3) const uint kTurns = 4; layout(constant_id = 4) const bool kDouble = true;
  layout(binding = 0) buffer Data { uint r[]; }; shared uint s[64];
  void main() {
    uint l = gl_LocalInvocationIndex, sum = 0u;
    for (uint turn = 0u; turn < r[0]; ++turn) {
      s[l] = r[l] + turn; barrier(); sum += s[63u - l]; barrier();
    }
    if (kDouble) sum *= 2u;
    if (r[1] == 7u) sum += r[2];
    for (uint turn = 0u; turn < kTurns; ++turn) sum = sum * 3u + 1u;
    r[gl_GlobalInvocationID.x] = sum;
  })";

ComputeSizes measure_glsl(const std::string& text, std::span<const spirv::SpecializationConstant> specialization) {
  const spirv::test::Words words = spirv::test::glsl(VK_SHADER_STAGE_COMPUTE_BIT, text);
  const auto module = spirv::parse(
      {.words = words, .entry_point = "main", .stage = VK_SHADER_STAGE_COMPUTE_BIT, .specialization = specialization});
  EXPECT_TRUE(module) << (module ? "" : module.error().text);
  const PipelineLayout layout{
      .bindings = {{.type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .count = 1, .stride_bytes = sizeof(BufferDescriptor)}}};
  const Result<ComputeSizes> sizes = measure_compute({.module = module->get(), .layout = &layout, .name = "test"});
  EXPECT_TRUE(sizes) << (sizes ? "" : sizes.error().text);
  return sizes ? *sizes : ComputeSizes{};
}

TEST(ExplainCompute, BarriersBranchesAndSpecialization) {
  const ComputeSizes own = measure_glsl(kBarriers, {});
  EXPECT_EQ(own.barriers, 2u);
  EXPECT_EQ(own.group_constructs, 2u);  // the loop with the barriers, and the If of its condition
  EXPECT_GT(own.frame_bytes, 0u);
  EXPECT_EQ(own.branches.unrolled, 1u);   // four turns
  EXPECT_EQ(own.branches.divergent, 0u);  // r[0] and r[1] are the same for all lanes
  // A loop of more turns than are unrolled stays; the multiplication by two goes.
  const std::vector<spirv::SpecializationConstant> given{{3, {100, 0, 0, 0}}, {4, {0, 0, 0, 0}}};
  const ComputeSizes other = measure_glsl(kBarriers, given);
  EXPECT_EQ(other.branches.unrolled, 0u);
  EXPECT_EQ(other.branches.uniform, own.branches.uniform + 1);
  EXPECT_EQ(other.barriers, 2u);
}

}  // namespace
}  // namespace pineda::compiler
