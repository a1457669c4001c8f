// Reading texels of a sampled image, and bringing them to the form in which they are filtered.
#pragma once

#include "compiler/kernels/sample_address.h"
#include "compiler/kernels/sample_lod.h"

namespace pineda::kernels {

// One level as a lane sees it; bytes from the image's address.
struct LevelView {
  std::array<AxisSize, 3> size;  // width, height, depth
  ir::Value offset_bytes, row_pitch_bytes;
};
// Without a level: level 0, constant over the draw.
LevelView view_level(ir::Builder& b, ir::Value image, const LevelIndex& level);

// Texels are filtered in code units (0..255 for 8-bit UNORM: F32 sums of at most 255 * 2^16 weights are exact) and scaled once,
// by finish().
class TexelReader {
 public:
  TexelReader(ir::Builder& b, const SampleSource& source, const FormatInfo& format);

  // Byte offsets: of a layer; of row y and slice z (unset: 0) of the level in its layer; of column x.
  ir::Value layer_offset(ir::Value layer);
  ir::Value row_offset(const LevelView& level, ir::Value y, ir::Value z);
  ir::Value column_offset(ir::Value x);

  // The texel at a byte offset, in filter units, border colour where `inside` (B1) is set and false. Components that the format
  // lacks are unset.
  Channels read(ir::Value offset_bytes, ir::Value inside) { return decode(read_words(offset_bytes), inside); }
  // The same in two steps.
  Words read_words(ir::Value offset_bytes);
  Channels decode(const Words& words, ir::Value inside);
  // The texel at a byte offset and its right neighbour in one access, for texels of one whole word. `second_row` (draw rate;
  // unset = 0) moves the base.
  bool reads_pairs() const { return format_.texel_bytes == 4; }
  std::array<Words, 2> read_pair(ir::Value offset_bytes, ir::Value second_row = {});
  // Texel indices are not bounded yet (texel fetch): lanes where `inside` is false read texels of zero bytes from now on.
  void check(ir::Value inside);

  // From filter units to values, defaults filled in.
  Channels finish(const Channels& filtered);

  bool normalized(uint32_t component) const;  // filtered in code units

 private:
  ir::Value component(uint32_t c, const Words& words);
  ir::Value border(uint32_t c);

  ir::Builder& b_;
  const SampleSource& source_;
  const FormatInfo& format_;
  ir::Value base_, limit_;
};

// The view's component swizzle, on values.
Channels swizzle(ir::Builder& b, const compiler::TextureState& state, const Channels& texel);
ir::Value swizzle_component(ir::Builder& b, const compiler::TextureState& state, const Channels& texel, uint32_t component);

}  // namespace pineda::kernels
