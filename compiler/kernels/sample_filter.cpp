#include "compiler/kernels/sample_filter.h"

#include "base/abi.h"
#include "compiler/kernels/depth.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

namespace {

constexpr std::array<Value, 1> kOneSlice{};  // of an image without depth

}  // namespace

Filter::Filter(Builder& b, const SampleSource& source, const spirv::SampleRequest& request, const FormatInfo& format)
    : b_(b),
      source_(source),
      state_(source.state),
      format_(format),
      cube_(is_cube(source.state.view_type)),
      request_(request),
      axes_(cube_ ? 2 : axis_count(source.state.view_type)),
      reduces_(state_.reduction != VK_SAMPLER_REDUCTION_MODE_WEIGHTED_AVERAGE && !request.depth_reference),
      reader_(b, source, format) {
  if (cube_) {
    FaceRequest on_face = select_face(b, request);
    request_ = on_face.request;
    face_ = on_face.face;
  }
  select_layer();
  if (request.depth_reference) {  // compared in the format's range
    const bool unorm = format.numeric == Numeric::kUnorm;
    reference_ = unorm ? clamp(b, request.depth_reference, 0, 1) : request.depth_reference;
  }
}

// RNE(layer), clamped to the view's layers; of cubes in an array, each six layers.
void Filter::select_layer() {
  if (is_array(state_.view_type)) {
    const Value index = b_.convert(Op::kFToS, Type::kI32, b_.fround_even(request_.coord[axes_]));
    Value count = b_.load(Type::kI32, source_.image, offsetof(ImageDescriptor, layer_count), kFixed);
    if (cube_) count = b_.udiv(count, b_.i32(6));
    array_layer_ = b_.smax(b_.smin(index, b_.isub(count, b_.i32(1))), b_.i32(0));
    if (cube_) array_layer_ = b_.imul(array_layer_, b_.i32(6));
  }
  const Value layer = cube_ && array_layer_ ? b_.iadd(array_layer_, face_) : cube_ ? face_ : array_layer_;
  if (layer) layer_offset_ = reader_.layer_offset(layer);
}

// ---- addresses ------------------------------------------------------------------------------------------------------------

AxisRequest Filter::axis(const LevelView& level, uint32_t a, const Coordinates& at) const {
  return {.coord = at[a],
          .size = level.size[a],
          .mode = cube_ ? VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE : state_.address[a],
          .unnormalized = state_.unnormalized,
          .offset = request_.offset[a],
          .dynamic_offset = request_.dynamic_offset[a],
          .unweighted = request_.gather_component >= 0};
}

Filter::Plane Filter::plane(const LevelView& level, const Coordinates& at) {
  Plane p{.axis = {}, .at = {}, .axes = std::min(axes_, 2u)};
  for (uint32_t a = 0; a < p.axes; ++a) {
    p.axis[a] = axis(level, a, at);
    p.at[a] = linear_position(b_, p.axis[a]);
  }
  return p;
}

Filter::Corners Filter::corners(const Plane& p) {
  if (p.interior) {
    const Value one = b_.i32(1), x = p.at[0].i0, y = p.at[1].i0;
    return {.column = {x, b_.iadd(x, one)}, .row = {y, b_.iadd(y, one)}, .inside_x = {}, .inside_y = {}};
  }
  const LinearTexels x = wrap_linear(b_, p.axis[0], p.at[0]);
  Corners c{.column = {x.i0, x.i1}, .row = {}, .inside_x = {x.inside0, x.inside1}, .inside_y = {}};
  if (p.axes == 1) return c;
  const LinearTexels y = wrap_linear(b_, p.axis[1], p.at[1]);
  c.row[0] = y.i0, c.row[1] = y.i1;
  c.inside_y[0] = y.inside0, c.inside_y[1] = y.inside1;
  return c;
}

// ---- texels ---------------------------------------------------------------------------------------------------------------

// One texel in filter units; the comparison's outcome when there is one.
Channels Filter::decode(const Words& words, Value inside) {
  Channels texel = reader_.decode(words, inside);
  if (!reference_) return texel;
  const Value depth = reader_.finish(texel)[0];
  return {b_.select(compare(b_, state_.compare, reference_, depth), b_.f32(1), b_.f32(0))};
}

Value Filter::row_offset(const LevelView& level, Value y, Value z) {
  const Value offset = reader_.row_offset(level, y, z);
  return layer_offset_ ? b_.iadd(offset, layer_offset_) : offset;
}

// Whether no lane's footprint is wrapped or leaves the image; wave rate.
Value Filter::is_interior(const LevelView& level, const Plane& p) {
  Value inside;
  for (uint32_t a = 0; a < p.axes; ++a) {
    const Value i = texel_before_wrapping(b_, p.axis[a], p.at[a]);
    const Value fits = b_.ult(i, b_.isub(level.size[a].texels, b_.i32(1)));
    inside = inside ? b_.and_(inside, fits) : fits;
  }
  return b_.ieq(b_.ballot(b_.not_(inside)), b_.i32(0));
}

Filter::TapWords Filter::read_apart(const LevelView& level, const Plane& p, Value z) {
  const Corners c = corners(p);
  const Value column[2] = {reader_.column_offset(c.column[0]), reader_.column_offset(c.column[1])};
  TapWords words{};
  for (uint32_t row = 0; row < p.axes; ++row) {
    const Value offset = row_offset(level, c.row[row], z);
    for (uint32_t i = 0; i < 2; ++i) words[2 * row + i] = reader_.read_words(b_.iadd(offset, column[i]));
  }
  return words;
}

// Of an interior footprint: where its first texel is.
Value Filter::pair_offset(const LevelView& level, const Plane& p, Value z) {
  const Value x = texel_before_wrapping(b_, p.axis[0], p.at[0]);
  const Value y = p.axes == 2 ? texel_before_wrapping(b_, p.axis[1], p.at[1]) : Value{};
  return b_.iadd(row_offset(level, y, z), reader_.column_offset(x));
}

// The two texels of a row follow each other, and so do the rows.
Filter::TapWords Filter::read_in_pairs(const LevelView& level, const Plane& p, Value offset) {
  TapWords words{};
  std::array<Words, 2> pair = reader_.read_pair(offset);
  words[0] = pair[0], words[1] = pair[1];
  if (p.axes == 1) return words;
  if (state_.single_level) {  // the pitch is the same for all lanes
    pair = reader_.read_pair(offset, level.row_pitch_bytes);
  } else {
    pair = reader_.read_pair(b_.iadd(offset, level.row_pitch_bytes));
  }
  words[2] = pair[0], words[3] = pair[1];
  return words;
}

// The footprint's texels in one slice or two. Most waves lie inside of the image: they need no wrapping and half the accesses.
std::vector<Filter::TapWords> Filter::read_words(const LevelView& level, const Plane& p, std::span<const Value> slices) {
  std::vector<TapWords> out;
  if (!reader_.reads_pairs()) {
    for (const Value z : slices) out.push_back(read_apart(level, p, z));
    return out;
  }
  std::vector<Value> offset;  // in front of the branch, where neighbouring samples share its parts
  for (const Value z : slices) offset.push_back(pair_offset(level, p, z));
  if (p.interior) {
    for (const Value at : offset) out.push_back(read_in_pairs(level, p, at));
    return out;
  }
  const uint32_t taps = 2 * p.axes;
  const auto list = [&](const auto& read) {
    std::vector<Value> words;
    for (size_t slice = 0; slice < slices.size(); ++slice) {
      const TapWords tap = read(slice);
      for (uint32_t i = 0; i < taps; ++i) words.push_back(tap[i][0]);
    }
    return words;
  };
  const std::vector<Value> words = b_.if_else(
      is_interior(level, p), std::vector<Type>(taps * slices.size(), Type::kI32),
      [&] { return list([&](size_t slice) { return read_in_pairs(level, p, offset[slice]); }); },
      [&] { return list([&](size_t slice) { return read_apart(level, p, slices[slice]); }); });
  for (size_t slice = 0; slice < slices.size(); ++slice) {
    TapWords& tap = out.emplace_back();
    for (uint32_t i = 0; i < taps; ++i) tap[i][0] = words[slice * taps + i];
  }
  return out;
}

Filter::Taps Filter::decode_plane(const TapWords& words, const Plane& p, Value inside_z) {
  const auto both = [&](Value v, Value w) { return v && w ? b_.and_(v, w) : v ? v : w; };
  const Corners c = corners(p);  // only `inside` is used
  Taps taps{};
  for (uint32_t tap = 0; tap < 2 * p.axes; ++tap) {
    taps[tap] = decode(words[tap], both(c.inside_x[tap & 1], both(c.inside_y[tap >> 1], inside_z)));
  }
  return taps;
}

// ---- bringing texels together -----------------------------------------------------------------------------------------------

Value Filter::reduce(Value first, Value second) {
  return state_.reduction == VK_SAMPLER_REDUCTION_MODE_MIN ? b_.fmin(first, second) : b_.fmax(first, second);
}

// first + weight2 * (second - first); the minimum or maximum of those that have a weight.
Channels Filter::blend(const Channels& first, const Channels& second, Value weight2) {
  Channels out{};
  for (const uint32_t c : present()) {
    out[c] = reduces_ ? b_.select(b_.fne(weight2, b_.f32(0)), reduce(first[c], second[c]), first[c])
                      : b_.fma(weight2, b_.fsub(second[c], first[c]), first[c]);
  }
  return out;
}

// Weights are multiples of 2^-16 that add up to one; in code units of 8-bit formats no step rounds.
Channels Filter::weighted(const Taps& taps, const Plane& p) {
  if (reduces_) {
    const Channels upper = blend(taps[0], taps[1], p.weight_x());
    return p.axes == 1 ? upper : blend(upper, blend(taps[2], taps[3], p.weight_x()), p.weight_y());
  }
  const Value one = b_.f32(1);
  const Value wx[2] = {b_.fsub(one, p.weight_x()), p.weight_x()};
  const Value wy[2] = {p.axes == 2 ? b_.fsub(one, p.weight_y()) : one, p.weight_y()};
  Channels sum{};
  for (uint32_t tap = 0; tap < 2 * p.axes; ++tap) {
    const Value weight = p.axes == 1 ? wx[tap & 1] : b_.fmul(wx[tap & 1], wy[tap >> 1]);
    for (const uint32_t c : present()) {
      sum[c] = sum[c] ? b_.fma(taps[tap][c], weight, sum[c]) : b_.fmul(taps[tap][c], weight);
    }
  }
  return sum;
}

// Whether texels are words of 8-bit UNORM components that no border colour replaces: then a row's two texels are weighted as
// pairs of 16 bits, four channels in four multiplications.
bool Filter::packs() const {
  for (uint32_t a = 0; a < axes_ && !cube_; ++a) {
    if (state_.address[a] == VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER) return false;
  }
  for (const ComponentBits& c : format_.component) {
    if (c.bits != 0 && (c.bits != 8 || c.first_bit % 8 != 0)) return false;
  }
  return format_.numeric == Numeric::kUnorm && format_.texel_bytes <= 4 && !reference_ && !reduces_;
}

// What weighted() computes, in integers while they are small: both are exact.
Channels Filter::weighted_bytes(const TapWords& words, const Plane& p) {
  const Value low = b_.i32(0xFFFF), high = b_.i32(0xFFFF0000), bytes = b_.i32(0x00FF00FF), shift16 = b_.i32(16),
              shift8 = b_.i32(8);
  const Value fx8 = p.at[0].weight1_fx8;
  const Value weights = b_.isub(b_.iadd(b_.shl(fx8, shift16), b_.i32(256)), fx8);  // 256 - w, w
  Channels sum{};
  for (uint32_t row = 0; row < p.axes; ++row) {
    const Value t0 = words[2 * row][0], t1 = words[2 * row + 1][0];
    // bytes 0 and 1 of both texels, and bytes 2 and 3
    const Value halves[2] = {b_.or_(b_.and_(t0, low), b_.shl(t1, shift16)), b_.or_(b_.lshr(t0, shift16), b_.and_(t1, high))};
    Value weight = b_.f32(1.0 / 256);
    if (p.axes == 2) weight = b_.fmul(row == 0 ? b_.fsub(b_.f32(1), p.weight_y()) : p.weight_y(), weight);
    for (const uint32_t c : present()) {
      const uint32_t byte = format_.component[c].first_bit / 8;
      const Value half = halves[byte / 2];
      const Value pair = b_.and_(byte % 2 == 0 ? half : b_.lshr(half, shift8), bytes);
      const Value mean = b_.convert(Op::kSToF, Type::kF32, b_.madd16(pair, weights));  // 0 .. 255 * 256
      sum[c] = sum[c] ? b_.fma(mean, weight, sum[c]) : b_.fmul(mean, weight);
    }
  }
  return sum;
}

Channels Filter::linear_plane(const TapWords& words, const Plane& p, Value inside_z) {
  return packs() ? weighted_bytes(words, p) : weighted(decode_plane(words, p, inside_z), p);
}

Channels Filter::linear(const LevelView& level, const Coordinates& at) {
  if (cube_) return linear_on_cube(level, at);
  const Plane p = plane(level, at);
  if (axes_ < 3) return linear_plane(read_words(level, p, kOneSlice)[0], p, {});
  const LinearTexels z = linear_texels(b_, axis(level, 2, at));
  const std::vector<TapWords> words = read_words(level, p, std::array{z.i0, z.i1});
  const Channels first = linear_plane(words[0], p, z.inside0);
  return blend(first, linear_plane(words[1], p, z.inside1), z.weight1);
}

Channels Filter::nearest(const LevelView& level, const Coordinates& at) {
  std::array<NearestTexel, 3> n{};
  Value inside;
  for (uint32_t a = 0; a < axes_; ++a) {
    n[a] = nearest_texel(b_, axis(level, a, at));
    if (n[a].inside) inside = inside ? b_.and_(inside, n[a].inside) : n[a].inside;
  }
  Value offset = b_.iadd(reader_.row_offset(level, n[1].i, n[2].i), reader_.column_offset(n[0].i));
  if (layer_offset_) offset = b_.iadd(offset, layer_offset_);
  return read(offset, inside);
}

// ---- cubes ----------------------------------------------------------------------------------------------------------------

Filter::Taps Filter::read_over_edges(const LevelView& level, const LinearPosition& x, const LinearPosition& y) {
  const Value one = b_.i32(1);
  const Value column[2] = {x.i0, b_.iadd(x.i0, one)}, row[2] = {y.i0, b_.iadd(y.i0, one)};
  Taps taps{};
  std::array<Value, 4> is_corner{};
  for (uint32_t tap = 0; tap < 4; ++tap) {
    const CubeTexel t = fold(b_, face_, column[tap & 1], row[tap >> 1], level.size[0].texels);
    const Value layer = array_layer_ ? b_.iadd(array_layer_, t.face) : t.face;
    const Value row_start = b_.iadd(reader_.row_offset(level, t.j, {}), reader_.layer_offset(layer));
    taps[tap] = read(b_.iadd(row_start, reader_.column_offset(t.i)), {});
    is_corner[tap] = t.corner;
  }
  fill_corner(taps, is_corner);
  return taps;
}

// Where three faces meet a footprint has three texels; the average of these stands for the fourth, as the specification
// recommends. At most one tap is a corner.
void Filter::fill_corner(Taps& taps, const std::array<Value, 4>& is_corner) {
  for (const uint32_t c : present()) {
    if (!ir::is_float(b_.type(taps[0][c]))) return;  // gathers of integers: the texel that fold() found
    Value sum = b_.f32(0);
    for (uint32_t tap = 0; tap < 4; ++tap) sum = b_.fadd(sum, b_.select(is_corner[tap], b_.f32(0), taps[tap][c]));
    const Value average = b_.fdiv(sum, b_.f32(3));
    for (uint32_t tap = 0; tap < 4; ++tap) taps[tap][c] = b_.select(is_corner[tap], average, taps[tap][c]);
  }
}

// The footprint's columns and rows may lie one beyond the face.
Channels Filter::linear_on_cube(const LevelView& level, const Coordinates& at) {
  Plane p = plane(level, at);
  p.interior = true;
  const Value last = b_.isub(level.size[0].texels, b_.i32(1));
  // i0 >= 0 and i0 + 1 < n, in one unsigned comparison
  const Value within = b_.and_(b_.ult(p.at[0].i0, last), b_.ult(p.at[1].i0, last));
  return channels_if(
      within, [&] { return linear_plane(read_words(level, p, kOneSlice)[0], p, {}); },
      [&] { return weighted(read_over_edges(level, p.at[0], p.at[1]), p); });
}

// ---- levels, filters, probes ------------------------------------------------------------------------------------------------

Channels Filter::filter_with(VkFilter filter, const LevelView& level, const Coordinates& at) {
  return filter == VK_FILTER_LINEAR && !format_.is_integer() ? linear(level, at) : nearest(level, at);
}

// Applies the minification or magnification filter, whichever each lane needs; a wave that needs one runs one.
Channels Filter::filter(const LevelChoice& choice, const LevelIndex& level, const Coordinates& at) {
  const LevelView view = view_level(b_, source_.image, level);
  if (!choice.magnify) return filter_with(state_.mag_filter, view, at);
  return channels_if(
      choice.magnify, [&] { return filter_with(state_.mag_filter, view, at); },
      [&] { return filter_with(state_.min_filter, view, at); });
}

// Lanes with fraction zero keep their first level, so a wave in which all do skips the second.
Channels Filter::sample_at(const Coordinates& at, const LevelChoice& choice) {
  const Channels first = filter(choice, choice.level0, at);
  if (!choice.fraction || format_.is_integer()) return first;
  return channels_if(
      b_.fne(choice.fraction, b_.f32(0)), [&] { return blend(first, filter(choice, choice.level1, at), choice.fraction); },
      [&] { return first; });
}

// tau_aniso = 1/N sum over i = 1..N of tau(p + step * (i / (N + 1) - 1/2)); minimum and maximum are over all probes.
Channels Filter::probes(const LevelChoice& choice) {
  const auto to_f32 = [&](Value i) { return b_.convert(Op::kSToF, Type::kF32, i); };
  const Value one = b_.i32(1);
  const Value spacing = b_.fdiv(b_.f32(1), to_f32(b_.iadd(choice.probes, one)));
  std::vector<Value> init{one};
  for (size_t c = 0; c < present().size(); ++c) init.push_back(b_.f32(0));
  const std::vector<Value> sums = b_.loop(init, [&](std::span<const Value> carried) {
    const Value i = carried[0], place = b_.fsub(b_.fmul(to_f32(i), spacing), b_.f32(0.5));
    Coordinates at{};
    for (uint32_t a = 0; a < axes_; ++a) at[a] = b_.fma(choice.step[a], place, request_.coord[a]);
    const std::vector<Value> texel = listed(sample_at(at, choice));
    Builder::LoopStep step{.again = b_.slt(i, choice.probes), .next = {b_.iadd(i, one)}};
    for (size_t c = 0; c < texel.size(); ++c) {
      const Value before = carried[c + 1];
      step.next.push_back(reduces_ ? b_.select(b_.ieq(i, one), texel[c], reduce(before, texel[c])) : b_.fadd(before, texel[c]));
    }
    return step;
  });
  Channels out = unlisted(std::span(sums).subspan(1));
  if (reduces_) return out;
  for (const uint32_t c : present()) out[c] = b_.fdiv(out[c], to_f32(choice.probes));
  return out;
}

Channels Filter::sample() {
  const LevelChoice choice = choose_levels(b_, source_, request_);
  const Coordinates at{request_.coord[0], request_.coord[1], request_.coord[2]};
  const bool one_probe = !choice.probes || format_.is_integer();
  const Channels texel = one_probe ? sample_at(at, choice) : probes(choice);
  if (reference_) return {texel[0], b_.f32(0), b_.f32(0), b_.f32(1)};
  return swizzle(b_, state_, reader_.finish(texel));
}

// The four texels of the linear footprint, counter-clockwise from the lower left (section 16.9.5 "Texel Gathering").
Channels Filter::gather() {
  LevelIndex level;
  if (!state_.single_level) level = choose_levels(b_, source_, request_).level0;
  const LevelView view = view_level(b_, source_.image, level);
  const Coordinates at{request_.coord[0], request_.coord[1], request_.coord[2]};
  const Plane p = plane(view, at);
  const Taps taps = cube_ ? read_over_edges(view, p.at[0], p.at[1]) : decode_plane(read_words(view, p, kOneSlice)[0], p, {});
  Channels out{};
  constexpr uint32_t kTap[4] = {2, 3, 1, 0};
  for (uint32_t i = 0; i < 4; ++i) {
    const Channels& texel = taps[axes_ == 1 ? kTap[i] & 1 : kTap[i]];
    const uint32_t component = static_cast<uint32_t>(request_.gather_component);
    out[i] = reference_ ? texel[0] : swizzle_component(b_, state_, reader_.finish(texel), component);
  }
  return out;
}

// ---- channels as lists ------------------------------------------------------------------------------------------------------

std::vector<uint32_t> Filter::present() const {
  std::vector<uint32_t> out;
  for (uint32_t c = 0; c < 4; ++c) {
    if (reference_ ? c == 0 : format_.component[c].bits != 0) out.push_back(c);
  }
  return out;
}

std::vector<Type> Filter::channel_types() const {
  return std::vector<Type>(present().size(), reference_ ? Type::kF32 : channel_type(format_));
}

std::vector<Value> Filter::listed(const Channels& texel) const {
  std::vector<Value> values;
  for (const uint32_t c : present()) values.push_back(texel[c]);
  return values;
}

Channels Filter::unlisted(std::span<const Value> values) const {
  Channels out{};
  size_t i = 0;
  for (const uint32_t c : present()) out[c] = values[i++];
  return out;
}

template <typename Then, typename Else>
Channels Filter::channels_if(Value cond, const Then& then_body, const Else& else_body) {
  return unlisted(b_.if_else(
      cond, channel_types(), [&] { return listed(then_body()); }, [&] { return listed(else_body()); }));
}

}  // namespace pineda::kernels
