// Resolve kernels: the N samples of a block -> one texel a pixel. Sums are formed as a tree, in types in which equal samples lose
// nothing: so a block of equal samples resolves to the sample, bit for bit.
#include <functional>

#include "base/abi.h"
#include "compiler/kernels/concat.h"
#include "compiler/kernels/kernels.h"
#include "compiler/kernels/samples.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

class Resolver {
 public:
  Resolver(Builder& b, const FormatInfo& format, VkResolveModeFlagBits mode, std::vector<Words> samples)
      : b_(b), format_(format), mode_(mode), samples_(std::move(samples)) {}

  Words texel() {
    if (mode_ == VK_RESOLVE_MODE_SAMPLE_ZERO_BIT) return samples_[0];
    std::array<Field, 4> fields{};
    for (uint32_t c = 0; c < 4; ++c) {
      if (format_.component[c].bits != 0) fields[c] = mode_ == VK_RESOLVE_MODE_AVERAGE_BIT ? average(c) : extreme(c);
    }
    return pack_fields(b_, format_, fields);
  }

 private:
  using Combine = std::function<Value(Value, Value)>;

  // Combines the samples' values two by two.
  Value tree(const std::function<Value(const Words&)>& value, const Combine& combine) {
    std::vector<Value> level;
    for (const Words& sample : samples_) level.push_back(value(sample));
    for (; level.size() > 1; level.resize(level.size() / 2)) {
      for (size_t i = 0; i < level.size() / 2; ++i) level[i] = combine(level[2 * i], level[2 * i + 1]);
    }
    return level[0];
  }

  double share() const { return 1.0 / static_cast<double>(samples_.size()); }

  Field average(uint32_t c) {
    if (is_unorm(format_, c) || format_.numeric == Numeric::kSnorm) return average_code(c);
    const auto value = [&](const Words& sample) {
      return b_.convert(Op::kFConvert, Type::kF64, unpack_component(b_, format_, c, sample));
    };
    const Value sum = tree(value, [&](Value x, Value y) { return b_.fadd(x, y); });
    const Value mean = b_.fmul(sum, b_.fconst(Type::kF64, share()));
    return pack_component(b_, format_, c, b_.convert(Op::kFConvert, Type::kF32, mean));
  }

  // Codes of at most 16 bits: their sums are exact, and the mean is rounded once.
  Field average_code(uint32_t c) {
    const bool is_signed = format_.numeric == Numeric::kSnorm;
    const auto value = [&](const Words& sample) {
      const Value code = extract_code(b_, format_, c, sample);
      if (!is_signed) return code;
      return b_.smax(code, b_.i32(static_cast<uint32_t>(-static_cast<int32_t>(code_scale(format_, c)))));
    };
    const Value sum = tree(value, [&](Value x, Value y) { return b_.iadd(x, y); });
    const Value mean = b_.fmul(b_.convert(Op::kSToF, Type::kF32, sum), b_.f32(share()));
    const Value code = b_.convert(Op::kFToS, Type::kI32, b_.fround_even(mean));
    return {code, is_signed ? format_.component[c].bits : 32u};
  }

  // Depth: floats, or codes; stencil: codes.
  Field extreme(uint32_t c) {
    const bool least = mode_ == VK_RESOLVE_MODE_MIN_BIT;
    if (format_.numeric == Numeric::kSfloat) {
      const auto value = [&](const Words& sample) { return unpack_component(b_, format_, c, sample); };
      return pack_component(b_, format_, c, tree(value, [&](Value x, Value y) { return least ? b_.fmin(x, y) : b_.fmax(x, y); }));
    }
    const auto value = [&](const Words& sample) { return extract_code(b_, format_, c, sample); };
    return {tree(value, [&](Value x, Value y) { return least ? b_.umin(x, y) : b_.umax(x, y); })};
  }

  Builder& b_;
  const FormatInfo& format_;
  const VkResolveModeFlagBits mode_;
  const std::vector<Words> samples_;
};

}  // namespace

Result<ir::Kernel> build_resolve(VkFormat format, uint32_t samples, VkResolveModeFlagBits mode) {
  const FormatInfo* info = find_format(format);
  if (!info || !info->is_plain() || !(info->uses & (kUseColor | kUseDepth))) {
    return compile_error(concat("Format ", static_cast<int>(format), " cannot be resolved."));
  }
  ir::Kernel kernel{
      .name = concat("resolve.", info->name), .kind = ir::KernelKind::kFragment, .wave_stride_bytes = sizeof(FragmentWave)};
  Builder b(kernel);
  const Value block_index = b.load(Type::kI32, b.wave_ptr(), offsetof(FragmentWave, block_index), kFixed);
  constexpr size_t kFrom = offsetof(ThreadContext, color), kTo = kFrom + sizeof(uint8_t*);
  std::vector<Words> words;
  for (uint32_t s = 0; s < samples; ++s) {
    words.push_back(TileBlock(b, *info, kFrom, sample_plane(b, samples, block_index, b.i32(s))).old(b));
  }
  // "If the source image has an integer format, a single sample's value is selected."
  if (info->is_integer() && mode == VK_RESOLVE_MODE_AVERAGE_BIT) mode = VK_RESOLVE_MODE_SAMPLE_ZERO_BIT;
  TileBlock(b, *info, kTo, block_index).replace(b, Resolver(b, *info, mode, std::move(words)).texel());
  return kernel;
}

}  // namespace pineda::kernels
