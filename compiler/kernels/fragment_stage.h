// What a fragment shader reads and writes: varyings, built-ins, colours, depth, masks.
#pragma once

#include <optional>

#include "compiler/kernels/blend.h"
#include "compiler/kernels/interpolate.h"
#include "compiler/kernels/stage.h"

namespace pineda::kernels {

// Where and for what the shader runs.
struct FragmentPlace {
  const Interpolator& position;
  uint32_t samples = 1;  // of a pixel
  ir::Value sample;      // I32, wave rate: the one that the shader runs for; unset when it runs for the whole pixel
  ir::Value covered;     // B1
  ir::Value mask;        // I32: covered samples of the lane; unset with one sample
};

class FragmentStage final : public Stage {
 public:
  // Emits what inputs are made of: construct it where that dominates the shader.
  FragmentStage(const compiler::GraphicsSource& source, ir::Builder& b, const FragmentPlace& place);

  ir::Value input(ir::Builder& b, const spirv::InterfaceScalar& in) override;
  ir::Value input_at(ir::Builder& b, const spirv::InterfaceScalar& in, const spirv::InterpolationPlace& place) override;
  void output(ir::Builder& b, const spirv::InterfaceScalar& out, ir::Value value) override;
  ir::Value covered(ir::Builder&) override { return place_.covered; }

  // What the shader has written; unset where it has not.
  std::array<ColorSources, kMaxColorAttachments> color{};
  ir::Value depth, sample_mask, stencil_reference;

 private:
  ir::Value built_in(ir::Builder& b, const spirv::InterfaceScalar& in);
  ir::Value frag_coord(ir::Builder& b, uint32_t component);
  PixelOffset centroid(ir::Builder& b) const;

  const FragmentPlace place_;
  const PixelOffset offset_;     // of what the shader runs for
  const Barycentrics at_;        // there
  const Barycentrics centroid_;  // for centroid inputs
};

}  // namespace pineda::kernels
