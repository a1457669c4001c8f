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
  register_pipeline_timestamp();
  register_texture();
  register_rasterization();
  register_draw();
  register_queries();
  register_block_layout();
  register_subgroups();
  register_multisample();
  register_info();
  register_compute();
  register_pipeline_constants();
  register_clipping();
  register_fragment_operations();
  register_api_copy();
  register_api_clear();
  register_robustness();
  register_memory();
  register_spirv_assembly();
  register_glsl_derivatives();
  register_glsl_interpolation();
  register_binding_model();
  register_image();
  register_synchronization();
  register_renderpass();
  register_wsi_headless();
}

}  // namespace pineda::cts
