// Each registers the cases of one file.
#pragma once

namespace pineda::cts {

void register_glsl_operators();
void register_glsl_builtins();
void register_pipeline_blend();
void register_pipeline_depth_stencil();
void register_pipeline_logic_op();
void register_pipeline_vertex_input();
void register_pipeline_timestamp();
void register_texture();
void register_rasterization();
void register_draw();
void register_queries();
void register_block_layout();
void register_subgroups();
void register_multisample();
void register_info();
void register_compute();
void register_pipeline_constants();
void register_clipping();
void register_fragment_operations();
void register_api_copy();
void register_api_clear();
void register_robustness();
void register_memory();
void register_spirv_assembly();
void register_glsl_derivatives();
void register_glsl_interpolation();
void register_binding_model();
void register_image();
void register_synchronization();
void register_renderpass();
void register_wsi_headless();

void register_self_test();  // in place of all others, for the test of this program

}  // namespace pineda::cts
