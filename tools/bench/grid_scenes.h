// A generated torus: lit, or only its depth; in one draw or in many, in one render pass or in many.
#pragma once

#include <memory>

#include "tools/scene.h"

namespace pineda::tools {

struct LitMeshOptions {
  uint32_t columns = 32, rows = 16;  // of quads, two triangles each
  bool depth_only = false;
  uint32_t draw_count = 1;  // drawn in this many equal parts
  float shift_x = 0;        // in half widths of the picture
  bool culled = false;      // both faces
};

std::unique_ptr<Scene> make_lit_mesh_scene(const LitMeshOptions& options);
// In `pass_count` render passes that do not depend on each other.
std::unique_ptr<Scene> make_many_passes_scene(const LitMeshOptions& options, uint32_t pass_count);

}  // namespace pineda::tools
