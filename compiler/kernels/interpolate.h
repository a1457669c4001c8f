// Where a fragment wave is, and its inputs: the formulas stand beside FragmentPrim in base/abi.h.
#pragma once

#include "compiler/ir/builder.h"
#include "compiler/spirv/translate.h"

namespace pineda::kernels {

// A place in a pixel, from its centre: F32, px, multiples of 1/256 of less than 1. Unset: the centre.
struct PixelOffset {
  ir::Value x, y;
};

// Where sample number `sample` (I32) lies.
PixelOffset sample_offset(ir::Builder& b, uint32_t samples, ir::Value sample);

// The weights of the vertices at one place of each pixel.
struct Barycentrics {
  ir::Value l1, l2;  // linear in the window
  // Perspective-correct, from vertex 1: of vertices 0 and 2. Where `flat` (B1: all vertices have one w), from vertex 0: of
  // vertices 1 and 2.
  ir::Value b_other, b2;
  ir::Value flat;
  ir::Value inverse_w;
};

class Interpolator {
 public:
  // Emits the position of the pixels' centres and their linear barycentrics.
  explicit Interpolator(ir::Builder& b);

  // Depth at the centre, and at a sample: the centre's plus what the plane's slopes make of the offset.
  ir::Value depth(ir::Builder& b) const;
  ir::Value depth(ir::Builder& b, const PixelOffset& offset) const;
  Barycentrics barycentrics(ir::Builder& b, const PixelOffset& offset) const;
  // Coordinates 0 and 1 of gl_FragCoord: pixel centres are at .5.
  ir::Value window_coordinate(ir::Builder& b, uint32_t axis, const PixelOffset& offset) const;
  // The attribute in slot `slot` of the vertex records.
  ir::Value varying(ir::Builder& b, uint32_t slot, const spirv::InterfaceScalar& in, const Barycentrics& at) const;

 private:
  ir::Value prim_f32(ir::Builder& b, size_t offset_bytes) const;
  ir::Value vertex(ir::Builder& b, uint32_t v) const;
  ir::Value linear(ir::Builder& b, size_t ddx, size_t ddy, ir::Value dx, ir::Value dy) const;

  ir::Value prim_;
  ir::Value x_px_, y_px_;  // of the pixel's top left corner
  ir::Value dx_, dy_;      // of the pixel's centre from vertex 0
  ir::Value l1_, l2_;      // linear barycentrics of the centre
};

}  // namespace pineda::kernels
