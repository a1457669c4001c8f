// Vertex kernel: 16 vertices -> clip positions and varyings.
#include <map>
#include <string>

#include "base/abi.h"
#include "compiler/kernels/kernels.h"
#include "compiler/kernels/stage.h"
#include "compiler/kernels/vertex_fetch.h"

namespace pineda::kernels {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;
using spirv::BuiltIn;

class VertexStage final : public Stage {
 public:
  VertexStage(Builder& b, const compiler::GraphicsSource& source)
      : Stage(*source.layout, source.textures), state_(source.vertex_input) {
    vertex_index_ = lane_index(b, offsetof(VertexWave, vertex_index));
    instance_index_ = lane_index(b, offsetof(VertexWave, instance_index));
  }

  Value input(Builder& b, const spirv::InterfaceScalar& in) override {
    if (const Value common = common_input(b, in)) return common;
    if (in.built_in) return built_in(b, *in.built_in);
    if (in.component > 3) return {};
    const Result<Channels> value = fetch_attribute(b, state_, in.location, vertex_index_, instance_index_);
    if (!value) {
      refuse(value.error().text);
      return {};
    }
    if (ir::size_bytes(in.type) != 4) return {};
    return b.bitcast(in.type, (*value)[in.component]);
  }

  void output(Builder& b, const spirv::InterfaceScalar& out, Value value) override {
    if (out.built_in) {
      if (*out.built_in == BuiltIn::kPosition && out.component < 4) outputs_[out.component] = value;
      if (const auto slot = built_in_slot(*out.built_in, out.component)) {
        outputs_[provisional_slot(slot->location, slot->component)] = value;
      }
      return;
    }
    if (ir::size_bytes(b.type(value)) == 4) outputs_[provisional_slot(out.location, out.component)] = value;
  }

  void store(Builder& b, std::span<const compiler::VaryingSlot> varyings) const {
    const Value record = b.load(Type::kPtr, b.wave_ptr(), offsetof(VertexWave, out), kFixed);
    for (uint32_t slot = 0; slot < 4 + varyings.size(); ++slot) {
      const uint32_t key = slot < 4 ? slot : provisional_slot(varyings[slot - 4].location, varyings[slot - 4].component);
      const auto found = outputs_.find(key);
      const Value value = found != outputs_.end() ? found->second : b.f32(0);  // what the shader leaves undefined
      b.store({.base = record, .offset = b.i32(slot * kVertexSlotBytes), .lane_stride = 4}, value);
    }
  }

 private:
  static Value lane_index(Builder& b, size_t offset_bytes) {
    const ir::Address at{.base = b.wave_ptr(), .offset = b.i32(static_cast<uint32_t>(offset_bytes)), .lane_stride = 4};
    return b.load(Type::kI32, at, kFixed);
  }

  Value built_in(Builder& b, BuiltIn which) {
    switch (which) {
      case BuiltIn::kVertexIndex:
        return vertex_index_;
      case BuiltIn::kInstanceIndex:
        return instance_index_;
      case BuiltIn::kBaseVertex:
        return load_draw(b, Type::kI32, offsetof(DrawContext, first_vertex));
      case BuiltIn::kBaseInstance:
        return load_draw(b, Type::kI32, offsetof(DrawContext, first_instance));
      case BuiltIn::kDrawIndex:
        return load_draw(b, Type::kI32, offsetof(DrawContext, draw_index));
      case BuiltIn::kViewIndex:
        return load_draw(b, Type::kI32, offsetof(DrawContext, view_index));
      default:
        return {};
    }
  }

  const compiler::VertexState& state_;
  Value vertex_index_, instance_index_;
  std::map<uint32_t, Value> outputs_;  // 0..3: position; then provisional_slot()
};

}  // namespace

Result<ir::Kernel> build_vertex(const compiler::GraphicsSource& source, const Shader& shader,
                                std::span<const compiler::VaryingSlot> varyings) {
  ir::Kernel kernel{.name = source.name + ".vertex", .kind = ir::KernelKind::kVertex, .wave_stride_bytes = sizeof(VertexWave)};
  Builder b(kernel);
  VertexStage stage(b, source);
  const Result<spirv::Translation> done = shader.body(b, stage);
  if (!done) return explain(done.error(), stage);
  stage.store(b, varyings);
  return kernel;
}

}  // namespace pineda::kernels
