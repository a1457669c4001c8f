// Filtering: which texels a sample touches, and how they are brought together (Vulkan 1.3, section 16.9 "Texel Filtering").
#pragma once

#include "compiler/kernels/sample_cube.h"
#include "compiler/kernels/sample_texel.h"

namespace pineda::kernels {

class Filter {
 public:
  // `request`: with gradients or an explicit LOD.
  Filter(ir::Builder& b, const SampleSource& source, const spirv::SampleRequest& request, const FormatInfo& format);

  Channels sample();
  Channels gather();

 private:
  using Coordinates = std::array<ir::Value, 3>;
  struct Plane {  // the linear footprint in x and y, before its texels are wrapped
    AxisRequest axis[2];
    LinearPosition at[2];
    uint32_t axes;
    bool interior = false;                                                          // all of it is known to lie in the image
    ir::Value weight_x() const { return at[0].weight1; }                            // F32, of the second column
    ir::Value weight_y() const { return axes == 2 ? at[1].weight1 : ir::Value{}; }  // of the second row; unset: one row
  };
  struct Corners {
    ir::Value column[2], row[2];         // texels
    ir::Value inside_x[2], inside_y[2];  // unset = always
  };
  using TapWords = std::array<Words, 4>;
  using Taps = std::array<Channels, 4>;  // (column 0, row 0), (1, 0), (0, 1), (1, 1)

  void select_layer();
  AxisRequest axis(const LevelView& level, uint32_t a, const Coordinates& at) const;
  Plane plane(const LevelView& level, const Coordinates& at);
  Corners corners(const Plane& p);
  std::vector<TapWords> read_words(const LevelView& level, const Plane& p, std::span<const ir::Value> slices);
  TapWords read_apart(const LevelView& level, const Plane& p, ir::Value z);
  ir::Value pair_offset(const LevelView& level, const Plane& p, ir::Value z);
  TapWords read_in_pairs(const LevelView& level, const Plane& p, ir::Value offset);
  ir::Value is_interior(const LevelView& level, const Plane& p);
  Taps decode_plane(const TapWords& words, const Plane& p, ir::Value inside_z);
  Channels read(ir::Value offset_bytes, ir::Value inside) { return decode(reader_.read_words(offset_bytes), inside); }
  Channels decode(const Words& words, ir::Value inside);

  Channels sample_at(const Coordinates& at, const LevelChoice& choice);
  Channels probes(const LevelChoice& choice);
  Channels filter(const LevelChoice& choice, const LevelIndex& level, const Coordinates& at);
  Channels filter_with(VkFilter filter, const LevelView& level, const Coordinates& at);
  Channels nearest(const LevelView& level, const Coordinates& at);
  Channels linear(const LevelView& level, const Coordinates& at);
  Channels linear_on_cube(const LevelView& level, const Coordinates& at);
  Taps read_over_edges(const LevelView& level, const LinearPosition& x, const LinearPosition& y);
  void fill_corner(Taps& taps, const std::array<ir::Value, 4>& is_corner);

  Channels weighted(const Taps& taps, const Plane& p);
  Channels linear_plane(const TapWords& words, const Plane& p, ir::Value inside_z);
  bool packs() const;
  Channels weighted_bytes(const TapWords& words, const Plane& p);
  ir::Value row_offset(const LevelView& level, ir::Value y, ir::Value z);
  Channels blend(const Channels& first, const Channels& second, ir::Value weight2);
  ir::Value reduce(ir::Value first, ir::Value second);
  std::vector<uint32_t> present() const;  // channels that taps have
  std::vector<ir::Type> channel_types() const;
  std::vector<ir::Value> listed(const Channels& texel) const;
  Channels unlisted(std::span<const ir::Value> values) const;
  template <typename Then, typename Else>
  Channels channels_if(ir::Value cond, const Then& then_body, const Else& else_body);

  ir::Builder& b_;
  const SampleSource& source_;
  const compiler::TextureState& state_;
  const FormatInfo& format_;
  const bool cube_;
  spirv::SampleRequest request_;  // on its face, for a cube
  ir::Value face_;                // I32; unset unless cube_
  ir::Value array_layer_;         // I32: the layer, or the first of a cube's six; unset = 0
  ir::Value layer_offset_;        // I32, bytes; unset = 0
  const uint32_t axes_;           // of a face, for a cube
  const bool reduces_;            // minimum or maximum instead of the average
  TexelReader reader_;
  ir::Value reference_;
};

}  // namespace pineda::kernels
