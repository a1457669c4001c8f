// Cube maps (Vulkan 1.3, sections 16.5.4 "Cube Map Face Selection" to 16.5.6, and 16.9.3 for the texels beyond a face's edges).
#pragma once

#include "compiler/kernels/sample.h"

namespace pineda::kernels {

// The request on the face that its direction selects: coordinates 0 and 1 (and their gradients) are those of the face, in [0, 1].
struct FaceRequest {
  spirv::SampleRequest request;
  ir::Value face;  // I32, 0..5
};
FaceRequest select_face(ir::Builder& b, const spirv::SampleRequest& request);

// The texel that stands at (i, j) of a face of n x n texels, where i and j may be one beyond its edges: then it is on a
// neighbouring face. Beyond a corner there is none: `corner`, and the texel is some texel of the cube.
struct CubeTexel {
  ir::Value face, i, j;  // I32
  ir::Value corner;      // B1
};
CubeTexel fold(ir::Builder& b, ir::Value face, ir::Value i, ir::Value j, ir::Value n);

}  // namespace pineda::kernels
