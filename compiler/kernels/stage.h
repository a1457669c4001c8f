// What every stage's StageInterface shares: descriptors, push constants, images.
#pragma once

#include <optional>
#include <span>

#include "compiler/compile.h"
#include "compiler/spirv/translate.h"

namespace pineda::kernels {

inline constexpr uint8_t kFixed = ir::kInvariant | ir::kSpeculate;  // loads of bound state: valid for all lanes, never written

class Stage : public spirv::StageInterface {
 public:
  Stage(const compiler::PipelineLayout& layout, std::span<const compiler::TextureUse> textures)
      : layout_(layout), textures_(textures) {}

  std::optional<spirv::BufferRef> buffer(ir::Builder& b, uint32_t set, uint32_t binding, ir::Value array_index) override;
  std::optional<std::array<ir::Value, 4>> sample(ir::Builder& b, const spirv::SampleRequest& request) override;
  std::optional<std::array<ir::Value, 4>> query(ir::Builder& b, const spirv::ImageQuery& query) override;
  std::optional<std::array<ir::Value, 4>> image_load(ir::Builder& b, const spirv::ImageAccess& access) override;
  std::optional<ir::Address> image_texel(ir::Builder& b, const spirv::ImageAccess& access) override;
  bool image_store(ir::Builder& b, const spirv::ImageAccess& access, std::span<const ir::Value> texel) override;
  ir::Value covered(ir::Builder&) override { return {}; }
  std::array<ir::Value, 2> address_ranges(ir::Builder& b) override;
  ir::Value shared_memory(ir::Builder&) override { return {}; }

  // Why the last request was refused; empty when none was.
  const std::string& refusal() const { return refusal_; }

 protected:
  const compiler::DescriptorBinding* find(uint32_t set, uint32_t binding) const;
  // Address of a descriptor (Ptr); array_index may be unset.
  ir::Value descriptor(ir::Builder& b, const compiler::DescriptorBinding& where, ir::Value array_index) const;
  const compiler::TextureState* texture_state(const spirv::ImageRef& image, const spirv::ImageRef& sampler) const;
  const compiler::TextureState* known_state(const spirv::ImageRef& image, const spirv::ImageRef& sampler, bool fetch) const;
  // Address of an ImageDescriptor, unset with a refusal when the layout has no such image.
  ir::Value image_descriptor(ir::Builder& b, const spirv::ImageRef& image);
  // Address of the sampler words that go with an image.
  ir::Value sampler_words(ir::Builder& b, const spirv::ImageRef& image, const spirv::ImageRef& sampler,
                          ir::Value image_descriptor);
  // Built-in inputs that every stage has: subgroups.
  static ir::Value common_input(ir::Builder& b, const spirv::InterfaceScalar& in);
  std::nullopt_t refuse(std::string why) {
    refusal_ = std::move(why);
    return std::nullopt;
  }

 private:
  const compiler::PipelineLayout& layout_;
  std::span<const compiler::TextureUse> textures_;
  std::string refusal_;
};

// Loads a field of the DrawContext.
ir::Value load_draw(ir::Builder& b, ir::Type type, size_t offset_bytes);

// The translator's error with the stage's reason, if it refused something.
inline std::unexpected<CompileError> explain(CompileError error, const Stage& stage) {
  if (!stage.refusal().empty()) error.text += " " + stage.refusal();
  return std::unexpected(std::move(error));
}

}  // namespace pineda::kernels
