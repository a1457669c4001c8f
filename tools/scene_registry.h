// The scenes that `compare`, `bench`, `render` and the golden tests know by name; any other name is the path of a model file.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "tools/scene.h"

namespace pineda::tools {

struct SceneInfo {
  const char* name;
  const char* title;
  const char* description;
  std::unique_ptr<Scene> (*create)();
  const char* model_path;  // of the named models, else null
  // Of the pixels, how many are within 1/255 of lavapipe's at least, where docs/differences.md explains why not all are; else 1.
  double explained_share = 1;
};

std::span<const SceneInfo> known_scenes();
const SceneInfo* find_scene(const std::string& name);  // null when it is not a known name
void require_scene(const std::string& name_or_path);   // throws ToolError when it is neither a known scene nor a readable file
std::unique_ptr<Scene> create_scene(const std::string& name_or_path);

}  // namespace pineda::tools
