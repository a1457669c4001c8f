#include "cts-subset/groups/groups.h"

#include "cts-subset/harness/case.h"

namespace pineda::cts {

void register_all_groups() {
  register_glsl_operators();
  register_glsl_builtins();
  register_pipeline_blend();
  register_pipeline_depth_stencil();
  register_pipeline_logic_op();
  register_pipeline_vertex_input();
  register_texture();
  register_rasterization();
  register_draw();
  register_queries();
  register_block_layout();
  register_subgroups();
  register_multisample();
}

}  // namespace pineda::cts
