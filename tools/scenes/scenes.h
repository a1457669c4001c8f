// The built-in scenes.
#pragma once

#include <memory>
#include <string>

#include "tools/scene.h"

namespace pineda::tools {

std::unique_ptr<Scene> make_triangle_scene();
std::unique_ptr<Scene> make_blend_scene();
std::unique_ptr<Scene> make_cubes_scene();
std::unique_ptr<Scene> make_mandelbrot_scene();
std::unique_ptr<Scene> make_primitives_scene();
enum class OitKind { kABuffer, kKBuffer };  // lists of all fragments; the four nearest
std::unique_ptr<Scene> make_oit_scene(OitKind kind);
std::unique_ptr<Scene> make_viewports_scene();
std::unique_ptr<Scene> make_deferred_scene();
std::unique_ptr<Scene> make_blocks_scene();
std::unique_ptr<Scene> make_blits_scene();
std::unique_ptr<Scene> make_model_scene(const std::string& path);

}  // namespace pineda::tools
