// A model file, whatever its format (assimp), as one vertex buffer, one index buffer and a list of draws.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tools/camera.h"
#include "tools/image.h"

namespace pineda::tools {

struct ModelVertex {
  glm::vec3 position, normal;
  glm::vec2 uv;  // (0, 0) is the top left corner of the texture
  std::array<uint8_t, 4> colour;
};

struct ModelMaterial {
  glm::vec4 base_colour{1};  // linear
  int texture = -1;          // into Model::textures, or -1
};

struct ModelDraw {  // one mesh of one node
  uint32_t first_index = 0, index_count = 0, vertex_offset = 0, material = 0;
  glm::mat4 world{1};
};

struct Model {
  std::vector<ModelVertex> vertices;
  std::vector<uint32_t> indices;
  std::vector<ModelDraw> draws;
  std::vector<ModelMaterial> materials;
  std::vector<Image> textures;
  std::vector<std::string> notes;  // what was left out, for the report

  std::vector<glm::vec3> world_positions() const;
  size_t triangle_count() const;
};

Model load_model(const std::string& path);  // throws ToolError

}  // namespace pineda::tools
