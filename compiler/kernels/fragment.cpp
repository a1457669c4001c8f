// Fragment kernel: one 4x4 block of a triangle. Order: coverage -> depth -> early test -> shader -> late test -> blend each
// attachment -> store.
#include <optional>

#include "base/abi.h"
#include "compiler/kernels/blend.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/depth.h"
#include "compiler/kernels/interpolate.h"
#include "compiler/kernels/kernels.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;
using spirv::BuiltIn;

class FragmentStage final : public Stage {
 public:
  FragmentStage(const compiler::GraphicsSource& source, const Interpolator& position, Value covered)
      : Stage(*source.layout, source.textures), position_(position), covered_(covered) {}

  Value input(Builder& b, const spirv::InterfaceScalar& in) override {
    if (const Value common = common_input(b, in)) return common;
    if (in.built_in) return built_in(b, in);
    if (ir::size_bytes(in.type) != 4 || in.component > 3) return {};
    return position_.varying(b, provisional_slot(in.location, in.component), in);
  }

  void output(Builder& b, const spirv::InterfaceScalar& out, Value value) override {
    if (out.built_in) {
      if (*out.built_in == BuiltIn::kFragDepth) depth = value;
      if (*out.built_in == BuiltIn::kSampleMask && out.component == 0) sample_mask = value;
    } else if (out.location < kMaxColorAttachments && out.component < 4 && out.index == 0 && ir::size_bytes(b.type(value)) == 4) {
      color[out.location][out.component] = value;
    }
  }

  Value covered(Builder&) override { return covered_; }

  std::array<Channels, kMaxColorAttachments> color{};
  Value depth, sample_mask;

 private:
  static Value prim_i32(Builder& b, size_t offset_bytes) {
    return b.load(Type::kI32, b.prim_ptr(), static_cast<uint32_t>(offset_bytes), kFixed);
  }

  static Value as(Builder& b, Type type, Value b1) { return type == Type::kB1 ? b1 : b.convert(Op::kZExt, type, b1); }

  Value built_in(Builder& b, const spirv::InterfaceScalar& in) {
    switch (*in.built_in) {
      case BuiltIn::kFragCoord:
        return position_.frag_coord(b, in.component);
      case BuiltIn::kFrontFacing:
        return as(b, in.type, b.ine(prim_i32(b, offsetof(FragmentPrim, front_facing)), b.i32(0)));
      case BuiltIn::kPrimitiveId:
        return prim_i32(b, offsetof(FragmentPrim, primitive_id));
      case BuiltIn::kLayer:
        return prim_i32(b, offsetof(FragmentPrim, layer));
      case BuiltIn::kViewportIndex:
        return prim_i32(b, offsetof(FragmentPrim, viewport_index));
      case BuiltIn::kViewIndex:
        return load_draw(b, Type::kI32, offsetof(DrawContext, view_index));
      case BuiltIn::kHelperInvocation:
        return as(b, in.type, b.not_(covered_));
      case BuiltIn::kPointCoord:
        return position_.point_coord(in.component);
      case BuiltIn::kClipDistance:
      case BuiltIn::kCullDistance: {
        const auto slot = built_in_slot(*in.built_in, in.component);
        return position_.varying(b, provisional_slot(slot->location, slot->component), in);
      }
      case BuiltIn::kSampleId:
        return b.i32(0);
      case BuiltIn::kSamplePosition:
        return b.f32(0.5);
      case BuiltIn::kSampleMask:
        return b.convert(Op::kZExt, Type::kI32, covered_);
      default:
        return {};
    }
  }

  const Interpolator& position_;
  const Value covered_;
};

class FragmentBuilder {
 public:
  FragmentBuilder(const compiler::GraphicsSource& source, const Shader* shader, FragmentKernel& out)
      : source_(source), shader_(shader), out_(out), b_(out.ir), position_(b_) {
    block_index_ = b_.load(Type::kI32, b_.wave_ptr(), offsetof(FragmentWave, block_index), kFixed);
    covered_ = b_.unpack_mask(b_.load(Type::kI32, b_.wave_ptr(), offsetof(FragmentWave, coverage), kFixed));
    depth_.emplace(b_, source.state, block_index_);
  }

  Result<void> build() {
    const bool forced_early = shader_ && shader_->info.early_fragment_tests;
    // A shader that only discards is tested early and written late: no other wave can come in between.
    out_.early_depth = forced_early || !shader_ || !(shader_->info.writes_depth || shader_->info.writes_memory);
    out_.has_side_effects = shader_ && shader_->info.writes_memory;
    if (!depth_->active() || !out_.early_depth) return shade();
    depth_->set_depth(b_, position_.depth(b_));
    covered_ = depth_->test(b_, covered_);
    Result<void> result;
    b_.if_(b_.ine(b_.ballot(covered_), b_.i32(0)), [&] {
      if (forced_early) depth_->write(b_, covered_);
      result = shade();
    });
    return result;
  }

 private:
  // Shader, late depth test, depth write, blending.
  Result<void> shade() {
    if (!shader_) {
      if (depth_->active()) depth_->write(b_, covered_);
      return {};
    }
    position_.begin_shading(b_);
    FragmentStage stage(source_, position_, covered_);
    const Result<spirv::Translation> done = shader_->body(b_, stage);
    if (!done) return explain(done.error(), stage);
    if (done->discarded) covered_ = b_.and_(covered_, b_.not_(done->discarded));
    if (stage.sample_mask) covered_ = b_.and_(covered_, b_.ine(b_.and_(stage.sample_mask, b_.i32(1)), b_.i32(0)));
    late_depth(stage);
    return write_colors(stage, done->discarded || stage.sample_mask);
  }

  void late_depth(const FragmentStage& stage) {
    if (!depth_->active() || shader_->info.early_fragment_tests) return;
    if (!out_.early_depth) {
      depth_->set_depth(b_, stage.depth ? stage.depth : position_.depth(b_));
      covered_ = depth_->test(b_, covered_);
    }
    depth_->write(b_, covered_);
  }

  Result<void> write_colors(const FragmentStage& stage, bool may_lose_lanes) {
    const compiler::FragmentState& state = source_.state;
    const compiler::DepthState& depth = state.depth;
    const bool depth_replaced =
        depth.format == VK_FORMAT_UNDEFINED || (depth.test_enable && depth.write_enable && depth.compare == VK_COMPARE_OP_ALWAYS);
    out_.opaque = depth_replaced && !may_lose_lanes && !out_.has_side_effects;
    for (uint32_t a = 0; a < state.color_count && a < kMaxColorAttachments; ++a) {
      if (state.color[a].format == VK_FORMAT_UNDEFINED) continue;
      if (const Result<void> done = write_color(a, stage.color[a]); !done) return done;
    }
    return {};
  }

  Result<void> write_color(uint32_t attachment, Channels source) {
    const compiler::BlendState& state = source_.state.color[attachment];
    const FormatInfo* format = find_format(state.format);
    if (!format || !(format->uses & kUseColor)) {
      return compile_error(concat("Format ", static_cast<int>(state.format), " cannot be a colour attachment."));
    }
    bool any = false;
    for (Value& value : source) {
      if (!value) continue;
      any = true;
      value = b_.bitcast(channel_type(*format), value);  // types agree in valid programs
    }
    // Without an output at this location the attachment's value is undefined: it stays.
    if (!any || written_components(state, *format) == 0) {
      out_.opaque = false;
      return {};
    }
    if (reads_destination(state, *format)) {
      out_.reads_color = true;
      out_.opaque = false;
    }
    TileBlock block(b_, *format, offsetof(ThreadContext, color) + attachment * sizeof(uint8_t*), block_index_);
    return blend_and_store(b_, state, *format, block, source, covered_);
  }

  const compiler::GraphicsSource& source_;
  const Shader* shader_;
  FragmentKernel& out_;
  Builder b_;
  Interpolator position_;
  Value block_index_, covered_;
  std::optional<DepthTest> depth_;
};

}  // namespace

Result<FragmentKernel> build_fragment(const compiler::GraphicsSource& source, const Shader* shader) {
  FragmentKernel out;
  out.ir.name = source.name + ".fragment";
  out.ir.kind = ir::KernelKind::kFragment;
  out.ir.wave_stride_bytes = sizeof(FragmentWave);
  FragmentBuilder builder(source, shader, out);
  if (const Result<void> done = builder.build(); !done) return std::unexpected(done.error());
  return out;
}

}  // namespace pineda::kernels
