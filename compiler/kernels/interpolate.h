// Where a fragment wave is, and its inputs: the formulas stand beside FragmentPrim in base/abi.h.
#pragma once

#include "compiler/ir/builder.h"
#include "compiler/spirv/translate.h"

namespace pineda::kernels {

class Interpolator {
 public:
  // Emits position and screen-space barycentrics.
  explicit Interpolator(ir::Builder& b);
  // Emits what only shading needs: 1/w and perspective-correct barycentrics. Once, where it dominates every varying.
  void begin_shading(ir::Builder& b);

  ir::Value depth(ir::Builder& b) const;
  ir::Value frag_coord(ir::Builder& b, uint32_t component) const;  // gl_FragCoord, pixel centres at .5
  ir::Value point_coord(uint32_t component) const { return component == 0 ? l1_ : l2_; }
  // The attribute in slot `slot` of the vertex records.
  ir::Value varying(ir::Builder& b, uint32_t slot, const spirv::InterfaceScalar& in) const;

 private:
  ir::Value prim_f32(ir::Builder& b, size_t offset_bytes) const;
  ir::Value vertex(ir::Builder& b, uint32_t v) const;

  ir::Value prim_;
  ir::Value x_px_, y_px_;  // of the pixel's top left corner
  ir::Value l1_, l2_;      // linear barycentrics
  ir::Value inverse_w_;
  ir::Value b1_, b2_;  // perspective-correct barycentrics
};

}  // namespace pineda::kernels
