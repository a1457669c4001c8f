// Rows of texels as vectors of four floats, for blits: what base/format.h does for one texel, faster for the common formats.
#pragma once

#include <cstdint>

#include "base/format.h"

namespace pineda::raster {

using Float4 = float __attribute__((vector_size(16)));

inline Float4 mix(Float4 a, Float4 b, float weight) { return a * (1 - weight) + b * weight; }

// A value in filter units: the code for components stored as UNORM or SNORM, the value for others.
class TexelRow {
 public:
  explicit TexelRow(const FormatInfo& format);

  // out[i] = texel columns[i] of the row, in filter units; absent components are 0, alpha 1.
  void read(const uint8_t* row, const uint32_t* columns, uint32_t count, Float4* out) const;
  // out[i] = texel first[i] * (1 - weight[i]) + texel second[i] * weight[i], in filter units: binary32, each operation rounded.
  void read_mixed(const uint8_t* row, const uint32_t* first, const uint32_t* second, const float* weight, uint32_t count,
                  Float4* out) const;
  // The code that stands for 1.0 in each component, or 1.
  Float4 scale() const { return scale_; }
  // Writes texels given in filter units of this format, already in range for normalized components.
  void write_units(const Float4* texels, uint32_t count, uint8_t* row) const;
  // The same of top[i] * (1 - weight) + bottom[i] * weight.
  void write_mixed_units(const Float4* top, const Float4* bottom, float weight, uint32_t count, uint8_t* row) const;
  // Writes texels given as values.
  void write_values(const Float4* texels, uint32_t count, uint8_t* row) const;

 private:
  bool is_four_bytes() const { return kind_ == Kind::kBytes && format_.texel_bytes == 4; }
  void write_bytes(const Float4* texels, uint32_t count, uint8_t* row) const;
  void write_srgb_bytes(const Float4* texels, uint32_t count, uint8_t* row) const;

  enum class Kind : uint8_t { kBytes, kSrgbBytes, kFloats, kHalves, kOther };
  static Kind kind_of(const FormatInfo& format);

  const FormatInfo& format_;
  const Kind kind_;
  uint32_t byte_of_[4] = {};  // kBytes, kSrgbBytes, in units of a component for kFloats and kHalves
  Float4 scale_;
};

}  // namespace pineda::raster
