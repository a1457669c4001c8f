#include "tools/model.h"

#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <new>

#include "tools/error.h"

namespace pineda::tools {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kPostProcess = aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_GenSmoothNormals |
                                  aiProcess_GenUVCoords | aiProcess_TransformUVCoords | aiProcess_SortByPType |
                                  aiProcess_FindInvalidData | aiProcess_ValidateDataStructure | aiProcess_FlipUVs;
constexpr unsigned kMaxNodeDepth = 512;  // a file may nest nodes without end
constexpr rlim_t kMaxLoadBytes = rlim_t{4} << 30;
constexpr size_t kMaxVertexCount = 50'000'000;  // 36 bytes each; more is a broken file or the wrong tool

glm::vec3 to_vec3(const aiVector3D& v) { return {v.x, v.y, v.z}; }

glm::mat4 to_mat4(const aiMatrix4x4& m) {  // assimp keeps rows, GLM columns
  return {m.a1, m.b1, m.c1, m.d1, m.a2, m.b2, m.c2, m.d2, m.a3, m.b3, m.c3, m.d3, m.a4, m.b4, m.c4, m.d4};
}

uint8_t to_byte(float value) { return static_cast<uint8_t>(std::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f); }

bool is_finite(glm::vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Bounds what an importer may allocate: a broken file can claim any size, and importers believe it. Allocations beyond it fail,
// which assimp reports as an error.
class MemoryLimit {
 public:
  explicit MemoryLimit(rlim_t additional_bytes) {
    std::ifstream statm("/proc/self/statm");
    rlim_t used_pages = 0;
    if (!(statm >> used_pages) || getrlimit(RLIMIT_AS, &before_) != 0) return;
    rlimit limited = before_;
    limited.rlim_cur =
        std::min<rlim_t>(before_.rlim_cur, used_pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + additional_bytes);
    is_set_ = setrlimit(RLIMIT_AS, &limited) == 0;
  }
  ~MemoryLimit() {
    if (is_set_) setrlimit(RLIMIT_AS, &before_);
  }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
  bool is_set_ = false;
};

class ModelLoader {
 public:
  explicit ModelLoader(const std::string& path) : path_(path) {}

  Model load() {
    importer_.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    scene_ = importer_.ReadFile(path_, kPostProcess);
    if (!scene_ || !scene_->mRootNode) fail("{}: cannot be loaded as a model: {}", path_, importer_.GetErrorString());
    for (unsigned i = 0; i < scene_->mNumMaterials; ++i) add_material(*scene_->mMaterials[i]);
    if (model_.materials.empty()) model_.materials.emplace_back();
    for (unsigned i = 0; i < scene_->mNumMeshes; ++i) add_mesh(*scene_->mMeshes[i]);
    add_node(*scene_->mRootNode, glm::mat4(1), 0);
    if (model_.draws.empty()) fail("{}: holds no triangles", path_);
    return std::move(model_);
  }

 private:
  void add_material(const aiMaterial& material) {
    ModelMaterial result;
    aiColor4D colour;
    if (material.Get(AI_MATKEY_BASE_COLOR, colour) == AI_SUCCESS || material.Get(AI_MATKEY_COLOR_DIFFUSE, colour) == AI_SUCCESS) {
      result.base_colour = {colour.r, colour.g, colour.b, 1};
    }
    aiString file;
    if (material.GetTexture(aiTextureType_BASE_COLOR, 0, &file) == AI_SUCCESS ||
        material.GetTexture(aiTextureType_DIFFUSE, 0, &file) == AI_SUCCESS) {
      result.texture = texture_index(file.C_Str());
      // Formats that give a texture in place of the diffuse colour leave the colour black.
      if (result.texture >= 0 && colour.r == 0 && colour.g == 0 && colour.b == 0) result.base_colour = glm::vec4(1);
    }
    model_.materials.push_back(result);
  }

  int texture_index(const std::string& name) {
    const auto [entry, is_new] = texture_indices_.try_emplace(name, -1);
    if (is_new) {
      try {
        model_.textures.push_back(load_texture(name));
        entry->second = static_cast<int>(model_.textures.size()) - 1;
      } catch (const ToolError& error) {
        model_.notes.push_back(fmt::format("texture left out: {}", error.what()));
      }
    }
    return entry->second;
  }

  Image load_texture(const std::string& name) {
    if (const aiTexture* embedded = scene_->GetEmbeddedTexture(name.c_str())) return decode_embedded(*embedded, name);
    std::string relative = name;
    std::replace(relative.begin(), relative.end(), '\\', '/');  // files from Windows
    const fs::path folder = fs::path(path_).parent_path();
    const fs::path candidates[] = {folder / relative, folder / fs::path(relative).filename()};
    std::error_code error;
    for (const fs::path& candidate : candidates) {
      if (fs::is_regular_file(candidate, error)) return load_image(candidate.string());
    }
    fail("{}: no such file", name);
  }

  static Image decode_embedded(const aiTexture& texture, const std::string& name) {
    if (texture.mHeight == 0) {  // a file in memory, mWidth bytes long
      return decode_image(reinterpret_cast<const uint8_t*>(texture.pcData), texture.mWidth, name);
    }
    Image image{.width = texture.mWidth, .height = texture.mHeight, .rgba = {}};
    image.rgba.reserve(size_t{4} * image.width * image.height);
    for (size_t i = 0; i < size_t{image.width} * image.height; ++i) {
      const aiTexel& texel = texture.pcData[i];
      image.rgba.insert(image.rgba.end(), {texel.r, texel.g, texel.b, texel.a});
    }
    return image;
  }

  struct MeshRange {
    uint32_t first_index = 0, index_count = 0, vertex_offset = 0, material = 0;
  };

  void add_mesh(const aiMesh& mesh) {
    MeshRange range{.first_index = static_cast<uint32_t>(model_.indices.size()),
                    .vertex_offset = static_cast<uint32_t>(model_.vertices.size()),
                    .material = std::min<uint32_t>(mesh.mMaterialIndex, static_cast<uint32_t>(model_.materials.size()) - 1)};
    if (model_.vertices.size() + mesh.mNumVertices > kMaxVertexCount) fail("{}: more than {} vertices", path_, kMaxVertexCount);
    if (mesh.HasPositions() && mesh.HasNormals()) {
      for (unsigned i = 0; i < mesh.mNumVertices; ++i) model_.vertices.push_back(make_vertex(mesh, i));
      for (unsigned i = 0; i < mesh.mNumFaces; ++i) add_face(mesh, mesh.mFaces[i]);
      range.index_count = static_cast<uint32_t>(model_.indices.size()) - range.first_index;
      orient(range);
    }
    meshes_.push_back(range);
  }

  static ModelVertex make_vertex(const aiMesh& mesh, unsigned i) {
    ModelVertex vertex{to_vec3(mesh.mVertices[i]), to_vec3(mesh.mNormals[i]), {0, 0}, {255, 255, 255, 255}};
    if (!is_finite(vertex.normal)) vertex.normal = {0, 1, 0};
    if (mesh.HasTextureCoords(0)) vertex.uv = glm::vec2(mesh.mTextureCoords[0][i].x, mesh.mTextureCoords[0][i].y);
    if (mesh.HasVertexColors(0)) {
      const aiColor4D& colour = mesh.mColors[0][i];
      vertex.colour = {to_byte(colour.r), to_byte(colour.g), to_byte(colour.b), 255};
    }
    return vertex;
  }

  void add_face(const aiMesh& mesh, const aiFace& face) {
    if (face.mNumIndices != 3) return;
    for (int corner = 0; corner < 3; ++corner) {
      const unsigned index = face.mIndices[corner];
      if (index >= mesh.mNumVertices || !is_finite(to_vec3(mesh.mVertices[index]))) return;
    }
    model_.indices.insert(model_.indices.end(), face.mIndices, face.mIndices + 3);
  }

  // Some files wind their triangles against their normals; the shader takes the facing from the winding, so make them agree.
  void orient(const MeshRange& range) {
    const ModelVertex* vertices = model_.vertices.data() + range.vertex_offset;
    const auto begin = model_.indices.begin() + range.first_index, end = model_.indices.end();
    int64_t balance = 0;
    for (auto i = begin; i != end; i += 3) {
      const ModelVertex &a = vertices[i[0]], &b = vertices[i[1]], &c = vertices[i[2]];
      const glm::vec3 normal = glm::cross(b.position - a.position, c.position - a.position);
      balance += glm::dot(normal, a.normal + b.normal + c.normal) >= 0 ? 1 : -1;
    }
    if (balance >= 0) return;
    for (auto i = begin; i != end; i += 3) std::swap(i[1], i[2]);
  }

  void add_node(const aiNode& node, const glm::mat4& parent, unsigned depth) {
    if (depth > kMaxNodeDepth) fail("{}: nodes are nested deeper than {}", path_, kMaxNodeDepth);
    const glm::mat4 world = parent * to_mat4(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= meshes_.size()) continue;
      const MeshRange& mesh = meshes_[node.mMeshes[i]];
      if (mesh.index_count == 0) continue;
      model_.draws.push_back({mesh.first_index, mesh.index_count, mesh.vertex_offset, mesh.material, world});
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) add_node(*node.mChildren[i], world, depth + 1);
  }

  std::string path_;
  Assimp::Importer importer_;
  const aiScene* scene_ = nullptr;
  Model model_;
  std::vector<MeshRange> meshes_;
  std::map<std::string, int> texture_indices_;
};

}  // namespace

std::vector<glm::vec3> Model::world_positions() const {
  std::vector<glm::vec3> positions;
  for (const ModelDraw& draw : draws) {
    for (uint32_t i = draw.first_index; i < draw.first_index + draw.index_count; ++i) {
      positions.emplace_back(draw.world * glm::vec4(vertices[draw.vertex_offset + indices[i]].position, 1));
    }
  }
  return positions;
}

size_t Model::triangle_count() const {
  size_t count = 0;
  for (const ModelDraw& draw : draws) count += draw.index_count / 3;
  return count;
}

Model load_model(const std::string& path) {
  const MemoryLimit limit(kMaxLoadBytes);
  try {
    return ModelLoader(path).load();
  } catch (const std::bad_alloc&) {
    fail("{}: needs more than {} GiB to load", path, kMaxLoadBytes >> 30);
  }
}

}  // namespace pineda::tools
