// Each registers the cases of one file.
#pragma once

namespace pineda::cts {

void register_glsl_operators();
void register_glsl_builtins();
void register_pipeline_blend();
void register_pipeline_depth_stencil();
void register_pipeline_logic_op();
void register_pipeline_vertex_input();
void register_texture();
void register_rasterization();
void register_draw();
void register_queries();
void register_block_layout();
void register_subgroups();
void register_multisample();

}  // namespace pineda::cts
