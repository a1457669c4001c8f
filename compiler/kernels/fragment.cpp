// Fragment kernel: one 4x4 block of a triangle. Order: coverage -> early tests -> shader -> late tests -> blend each attachment
// -> store.
//
// With several samples a pixel there are two kinds. A kernel that runs for each sample is the kernel of one sample, at another
// place of the pixel and with a buffer of its own. One that runs for the pixel keeps a mask of samples for each lane: tests and
// colours go through them one after another, but for colours there is a shortcut where the samples cannot differ
// (ThreadContext::equal_samples).
#include <algorithm>
#include <optional>

#include "base/abi.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/depth.h"
#include "compiler/kernels/fragment_stage.h"
#include "compiler/kernels/kernels.h"
#include "compiler/kernels/samples.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;
using spirv::BuiltIn;

bool declares(std::span<const spirv::InterfaceScalar> scalars, BuiltIn built_in) {
  return std::ranges::any_of(scalars, [&](const spirv::InterfaceScalar& s) { return s.built_in == built_in; });
}

// "If a fragment shader entry point statically uses an input variable decorated with SampleId, SamplePosition or Sample, sample
// shading is enabled".
bool runs_per_sample(const compiler::FragmentState& state, const Shader* shader) {
  if (state.samples == 1 || !shader) return false;
  const auto& inputs = shader->info.inputs;
  return state.sample_shading || declares(inputs, BuiltIn::kSampleId) || declares(inputs, BuiltIn::kSamplePosition) ||
         std::ranges::any_of(inputs, [](const auto& in) { return in.at == spirv::InterpolationAt::kSample; });
}

// An attachment that the shader writes.
struct ColorTarget {
  uint32_t attachment;
  ColorOperation operation;
  ColorSources sources;
};

class FragmentBuilder {
 public:
  FragmentBuilder(const compiler::GraphicsSource& source, const Shader* shader, FragmentKernel& out)
      : source_(source), state_(source.state), shader_(shader), out_(out), b_(out.ir), position_(b_) {
    out.per_sample = runs_per_sample(state_, shader);
    by_pixel_ = state_.samples > 1 && !out.per_sample;
    out.ir.wave_stride_bytes = by_pixel_ || state_.smooth_lines ? sizeof(FragmentSampleWave) : sizeof(FragmentWave);
    block_index_ = b_.load(Type::kI32, b_.wave_ptr(), offsetof(FragmentWave, block_index), kFixed);
    begin_coverage();
    loses_lanes_ = state_.alpha_to_coverage ||
                   (shader && (shader->info.uses_discard || declares(shader->info.outputs, BuiltIn::kSampleMask)));
    tests_ = has_depth_stencil(state_);
    if (tests_ && !by_pixel_) one_test_.emplace(b_, state_, block_index_);
  }

  Result<void> build() {
    const bool forced_early = shader_ && shader_->info.early_fragment_tests;
    const bool needs_outputs =
        shader_ && (exports_depth() || shader_->info.writes_memory || declares(shader_->info.outputs, BuiltIn::kFragStencilRef) ||
                    (state_.stencil.writes() && loses_lanes_));
    // A shader that only discards is tested early and written late: no other wave can come in between.
    out_.early_depth = forced_early || !needs_outputs;
    out_.has_side_effects = shader_ && shader_->info.writes_memory;
    if (!tests_) return shade();
    if (!out_.early_depth) {
      if (exports_depth()) out_.late_depth = depth_mode();
      return may_fail_early() ? shade_what_may_pass() : shade();
    }
    test_early(forced_early || !loses_lanes_);
    Result<void> result;
    b_.if_(b_.ine(b_.ballot(covered_), b_.i32(0)), [&] {
      if (one_test_ && forced_early) one_test_->write_depth(b_, covered_);
      result = shade();
    });
    return result;
  }

 private:
  // ---- conservative depth -------------------------------------------------------------------------------------------------
  // A shader that promises on which side of the interpolated depth its own will be (execution modes DepthGreater, DepthLess and
  // DepthUnchanged) is held to it, so a test that fails for the one fails for the other, and no bit depends on who looks first.
  // With several samples the promise would be about depths that the shader does not see.

  spirv::DepthMode depth_mode() const {
    return shader_ && state_.samples == 1 ? shader_->info.depth_mode : spirv::DepthMode::kAny;
  }
  bool exports_depth() const { return shader_->info.writes_depth && depth_mode() != spirv::DepthMode::kUnchanged; }

  Value kept_promise(Value exported) {
    switch (depth_mode()) {
      case spirv::DepthMode::kGreater:
        return b_.fmax(depth_of_sample(), exported);
      case spirv::DepthMode::kLess:
        return b_.fmin(depth_of_sample(), exported);
      case spirv::DepthMode::kUnchanged:
        return depth_of_sample();
      case spirv::DepthMode::kAny:
        break;
    }
    return exported;
  }

  bool may_fail_early() const {
    const VkCompareOp op = state_.depth.compare;
    const bool greater = op == VK_COMPARE_OP_GREATER || op == VK_COMPARE_OP_GREATER_OR_EQUAL;
    const bool less = op == VK_COMPARE_OP_LESS || op == VK_COMPARE_OP_LESS_OR_EQUAL;
    const bool decided =
        (less && out_.late_depth == spirv::DepthMode::kGreater) || (greater && out_.late_depth == spirv::DepthMode::kLess);
    return decided && state_.depth.test_enable && one_test_ && !state_.stencil.writes() && !shader_->info.writes_memory &&
           !declares(shader_->info.outputs, BuiltIn::kFragStencilRef);
  }

  // The block is left out when no lane passes with the interpolated depth.
  Result<void> shade_what_may_pass() {
    DepthStencil interpolated(b_, state_, block_index_);
    interpolated.set_depth(b_, depth_of_sample());
    Result<void> result;
    b_.if_(b_.ine(b_.ballot(interpolated.test(b_, covered_)), b_.i32(0)), [&] { result = shade(); });
    return result;
  }

  // ---- coverage -----------------------------------------------------------------------------------------------------------

  void begin_coverage() {
    const uint32_t all = (1u << state_.samples) - 1, wanted = state_.sample_mask & all;
    if (state_.smooth_lines) line_area_ = load_samples();
    if (by_pixel_ && state_.smooth_lines) {
      set_mask(b_.select(b_.ine(line_area_, b_.i32(0)), b_.i32(wanted), b_.i32(0)));
      return;
    }
    if (by_pixel_) {
      set_mask(load_samples());
      if (wanted != all) set_mask(b_.and_(mask_, b_.i32(wanted)));
      return;
    }
    covered_ = b_.unpack_mask(b_.load(Type::kI32, b_.wave_ptr(), offsetof(FragmentWave, coverage), kFixed));
    if (out_.per_sample) sample_ = b_.and_(block_index_, b_.i32(state_.samples - 1));
    if (wanted != all) keep_samples(b_.i32(wanted));
    if (out_.per_sample) mask_ = b_.select(covered_, b_.shl(b_.i32(1), sample_), b_.i32(0));
  }

  Value load_samples() {
    const ir::Address samples{
        .base = b_.wave_ptr(), .offset = b_.i32(offsetof(FragmentSampleWave, samples)), .lane_stride = sizeof(uint16_t)};
    return b_.convert(Op::kZExt, Type::kI32, b_.load(Type::kI16, samples, kFixed));
  }

  void set_mask(Value mask) {
    mask_ = mask;
    covered_ = b_.ine(mask, b_.i32(0));
  }

  // Takes away lanes outside of `lanes` (B1).
  void keep_lanes(Value lanes) {
    if (by_pixel_) {
      set_mask(b_.select(lanes, mask_, b_.i32(0)));
    } else {
      covered_ = b_.and_(covered_, lanes);
    }
  }

  // Takes away samples whose bit is not in `bits` (I32).
  void keep_samples(Value bits) {
    if (by_pixel_) {
      set_mask(b_.and_(mask_, bits));
    } else {
      const Value own = sample_ ? b_.lshr(bits, sample_) : bits;
      covered_ = b_.and_(covered_, b_.ine(b_.and_(own, b_.i32(1)), b_.i32(0)));
    }
  }

  // "The fragment's alpha determines a temporary coverage mask": round(alpha * samples) samples stay, those of low numbers; no
  // dither, so equal alphas have equal coverage.
  Value alpha_coverage(const FragmentStage& stage) {
    const Value alpha = stage.color[0].first[3] ? stage.color[0].first[3] : b_.f32(1);
    const Value scaled = b_.fmul(clamp(b_, b_.bitcast(Type::kF32, alpha), 0, 1), b_.f32(state_.samples));
    const Value count = b_.convert(Op::kFToS, Type::kI32, b_.ffloor(b_.fadd(scaled, b_.f32(0.5))));
    return b_.isub(b_.shl(b_.i32(1), count), b_.i32(1));
  }

  // ---- tests --------------------------------------------------------------------------------------------------------------

  // `write`: now, not after the shader. With one sample depth is always written after it, which keeps fewer values alive.
  void test_early(bool write) {
    if (!one_test_) return test_samples(true, write, nullptr);
    one_test_->set_depth(b_, depth_of_sample());
    covered_ = one_test_->test(b_, covered_);
    one_test_->write_stencil(b_);
  }

  void test_late(const FragmentStage* stage) {
    const bool forced_early = shader_ && shader_->info.early_fragment_tests;
    if (!tests_ || forced_early) return;
    if (!one_test_) {
      if (!out_.early_depth || loses_lanes_) test_samples(!out_.early_depth, true, stage);
      return;
    }
    if (!out_.early_depth) {
      one_test_->set_depth(b_, stage->depth ? kept_promise(stage->depth) : depth_of_sample());
      if (stage->stencil_reference) one_test_->set_stencil_reference(stage->stencil_reference);
      covered_ = one_test_->test(b_, covered_);
      one_test_->write_stencil(b_);
    }
    one_test_->write_depth(b_, covered_);
  }

  Value depth_of_sample() {
    return sample_ ? position_.depth(b_, sample_offset(b_, state_.samples, sample_)) : position_.depth(b_);
  }

  void test_samples(bool test, bool write, const FragmentStage* stage) {
    set_mask(filter_samples(b_, state_.samples, mask_, [&](Value sample, Value covered) {
      DepthStencil one(b_, state_, plane(sample));
      const bool exported = stage && stage->depth;
      one.set_depth(b_, exported ? stage->depth : position_.depth(b_, sample_offset(b_, state_.samples, sample)));
      if (stage && stage->stencil_reference) one.set_stencil_reference(stage->stencil_reference);
      const Value passed = test ? one.test(b_, covered) : covered;
      if (test && write) one.write_stencil(b_);
      if (write) one.write_depth(b_, passed);
      return passed;
    }));
  }

  Value plane(Value sample) { return sample_plane(b_, state_.samples, block_index_, sample); }

  // ---- shading ------------------------------------------------------------------------------------------------------------

  // Shader, late tests, blending.
  Result<void> shade() {
    if (!shader_) {
      test_late(nullptr);
      count_samples();
      return {};
    }
    FragmentStage stage(source_, b_, {position_, state_.samples, sample_, covered_, mask_});
    const Result<spirv::Translation> done = shader_->body(b_, stage);
    if (!done) return explain(done.error(), stage);
    if (done->discarded) keep_lanes(b_.not_(done->discarded));
    loses_lanes_ |= static_cast<bool>(done->discarded);
    if (state_.alpha_to_coverage) keep_samples(alpha_coverage(stage));
    if (stage.sample_mask) keep_samples(stage.sample_mask);
    test_late(&stage);
    count_samples();
    return write_colors(stage);
  }

  // Occlusion queries: draws outside of one pay for a branch that is always predicted.
  void count_samples() {
    const Value counts = load_draw(b_, Type::kI32, offsetof(DrawContext, count_samples));
    b_.if_(b_.ine(counts, b_.i32(0)), [&] {
      Value sum = b_.i32(0);
      for (uint32_t s = 0; s < (by_pixel_ ? state_.samples : 1); ++s) {
        const Value passed = by_pixel_ ? b_.ine(b_.and_(mask_, b_.i32(1u << s)), b_.i32(0)) : covered_;
        sum = b_.iadd(sum, b_.popcount(b_.ballot(passed)));
      }
      const uint32_t at = offsetof(ThreadContext, samples_passed);
      const Value total = b_.iadd(b_.load(Type::kI64, b_.thread_ptr(), at), b_.convert(Op::kZExt, Type::kI64, sum));
      b_.store({.base = b_.thread_ptr(), .offset = b_.i32(at)}, total);
    });
  }

  // ---- colours ------------------------------------------------------------------------------------------------------------

  // Whether a fully covered block replaces what was there, as far as depth, stencil and lanes decide.
  bool covers_opaquely() const {
    const compiler::DepthState& depth = state_.depth;
    const bool depth_replaced =
        depth.format == VK_FORMAT_UNDEFINED || (depth.test_enable && depth.write_enable && depth.compare == VK_COMPARE_OP_ALWAYS);
    const uint32_t all = (1u << state_.samples) - 1;
    return depth_replaced && !state_.smooth_lines && !depth.bounds_test && !state_.stencil.test_enable && !loses_lanes_ &&
           !out_.has_side_effects && (state_.sample_mask & all) == all;
  }

  Result<void> write_colors(const FragmentStage& stage) {
    out_.opaque = covers_opaquely();
    std::vector<ColorTarget> targets;
    bool replaces = true;  // what is written leaves nothing of any attachment
    for (uint32_t a = 0; a < state_.color_count && a < kMaxColorAttachments; ++a) {
      if (state_.color[a].format == VK_FORMAT_UNDEFINED) continue;
      Result<std::optional<ColorTarget>> target = color_target(a, stage.color[a]);
      if (!target) return std::unexpected(target.error());
      const bool reads = *target && reads_destination((*target)->operation);
      out_.reads_color |= reads;
      replaces &= *target && !reads;
      if (*target) targets.push_back(**target);
    }
    out_.opaque &= replaces;
    if (by_pixel_ && !state_.equal_samples) {
      write_each_sample(targets);
    } else if (by_pixel_) {
      if (!targets.empty()) write_samples(targets, replaces);
    } else {
      for (const ColorTarget& target : targets) write_plane(target, block_index_, covered_);
    }
    return {};
  }

  // Nothing when the attachment stays as it is: without an output at this location its value would be undefined.
  Result<std::optional<ColorTarget>> color_target(uint32_t attachment, ColorSources sources) {
    const compiler::BlendState& state = state_.color[attachment];
    const FormatInfo* format = find_format(state.format);
    if (!format || !(format->uses & kUseColor)) {
      return compile_error(concat("Format ", static_cast<int>(state.format), " cannot be a colour attachment."));
    }
    const ColorOperation operation{state, *format, state_.logic_op};
    if (const Result<void> ok = check(operation); !ok) return std::unexpected(ok.error());
    bool any = false;
    for (Channels* channels : {&sources.first, &sources.second}) {
      for (Value& value : *channels) {
        if (!value) continue;
        any = true;
        value = b_.bitcast(channel_type(*format), value);  // types agree in valid programs
      }
    }
    if (!any || written_components(state, *format) == 0) return std::nullopt;
    // "This coverage value is multiplied into the color location 0's alpha value after fragment shading."
    if (state_.smooth_lines && attachment == 0 && !format->is_integer() && sources.first[3]) {
      const Value part = b_.fdiv(b_.convert(Op::kUToF, Type::kF32, line_area_), b_.f32(65535));
      sources.first[3] = b_.fmul(sources.first[3], part);
    }
    if (state_.alpha_to_one && !format->is_integer()) sources.first[3] = sources.second[3] = b_.f32(1);
    return ColorTarget{attachment, operation, sources};
  }

  void write_plane(const ColorTarget& target, Value plane, Value covered) {
    TileBlock block(b_, target.operation.format, color_offset(target.attachment), plane);
    blend_and_store(b_, target.operation, block, target.sources, covered);
  }

  static size_t color_offset(uint32_t attachment) { return offsetof(ThreadContext, color) + attachment * sizeof(uint8_t*); }

  // All samples of the block. Sample 0 alone where all are equal before and after.
  void write_samples(const std::vector<ColorTarget>& targets, bool replaces) {
    const Value full = b_.ieq(mask_, b_.i32((1u << state_.samples) - 1));
    const Value whole = b_.ieq(b_.ballot(b_.and_(covered_, b_.not_(full))), b_.i32(0));  // each lane: all samples or none
    EqualSamples equal(b_, block_index_);
    const Value was_equal = equal.load(b_);
    Value stays_equal = was_equal;
    if (replaces) stays_equal = b_.or_(stays_equal, b_.ieq(b_.ballot(full), b_.i32(0xFFFF)));
    b_.if_else(
        b_.and_(whole, stays_equal),
        [&] {
          for (const ColorTarget& target : targets) write_plane(target, plane(b_.i32(0)), covered_);
          if (replaces) equal.store(b_, true);
        },
        [&] {
          b_.if_(was_equal, [&] {
            for (uint32_t a = 0; a < state_.color_count; ++a) {
              if (const FormatInfo* format = find_format(state_.color[a].format))
                spread_sample_0(b_, *format, color_offset(a), state_.samples, block_index_);
            }
            equal.store(b_, false);
          });
          write_each_sample(targets);
        });
  }

  void write_each_sample(const std::vector<ColorTarget>& targets) {
    for_samples(b_, state_.samples, [&](Value sample) {
      const Value covered = b_.ine(b_.and_(b_.lshr(mask_, sample), b_.i32(1)), b_.i32(0));
      for (const ColorTarget& target : targets) write_plane(target, plane(sample), covered);
    });
  }

  const compiler::GraphicsSource& source_;
  const compiler::FragmentState& state_;
  const Shader* shader_;
  FragmentKernel& out_;
  Builder b_;
  Interpolator position_;
  Value block_index_;
  Value covered_;          // B1: with several samples, some of the lane's
  Value mask_;             // I32: samples of the lane; unset with one
  Value line_area_;        // I32: of smooth lines
  Value sample_;           // I32: what a kernel that runs for each sample runs for
  bool by_pixel_ = false;  // several samples, one run of the shader
  bool loses_lanes_ = false, tests_ = false;
  std::optional<DepthStencil> one_test_;  // unless by pixel
};

}  // namespace

Result<FragmentKernel> build_fragment(const compiler::GraphicsSource& source, const Shader* shader) {
  FragmentKernel out;
  out.ir.name = source.name + ".fragment";
  out.ir.kind = ir::KernelKind::kFragment;
  FragmentBuilder builder(source, shader, out);
  if (const Result<void> done = builder.build(); !done) return std::unexpected(done.error());
  return out;
}

}  // namespace pineda::kernels
