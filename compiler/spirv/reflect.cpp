// ModuleInfo's dynamic part, by a trial translation against a stage that accepts everything and takes notes. Images can be passed
// through functions, so only the walk that inlines them knows which image meets which sampler; and a module that parse() accepts
// is one whose every instruction translates.
#include <algorithm>

#include "compiler/spirv/translator.h"

namespace pineda::spirv {
namespace {

class Recorder final : public StageInterface {
 public:
  explicit Recorder(ModuleInfo& info) : info_(info) {}

  ir::Value input(ir::Builder& b, const InterfaceScalar& in) override { return b.zero(in.type); }
  ir::Value input_at(ir::Builder& b, const InterfaceScalar& in, const InterpolationPlace&) override { return b.zero(in.type); }
  void output(ir::Builder&, const InterfaceScalar&, ir::Value) override {}
  std::optional<BufferRef> buffer(ir::Builder& b, uint32_t, uint32_t, ir::Value) override {
    return BufferRef{.base = b.draw_ptr(), .size_bytes = b.i32(0)};
  }
  std::optional<std::array<ir::Value, 4>> sample(ir::Builder& b, const SampleRequest& r) override {
    add({.image = r.image, .sampler = r.sampler, .sampled = true, .view_type = r.view_type});
    return texel(b, r.result);
  }
  std::optional<std::array<ir::Value, 4>> query(ir::Builder& b, const ImageQuery& q) override {
    if (q.kind == ImageQuery::Kind::kLod)
      add({.image = q.image, .sampler = q.sampler, .sampled = true, .view_type = q.view_type});
    return texel(b, q.kind == ImageQuery::Kind::kLod ? ir::Type::kF32 : ir::Type::kI32);
  }
  std::optional<std::array<ir::Value, 4>> image_load(ir::Builder& b, const ImageAccess& a) override {
    add({.image = a.image, .sampler = a.image, .sampled = false, .view_type = a.view_type});
    return texel(b, a.component);
  }
  bool image_store(ir::Builder&, const ImageAccess& a, std::span<const ir::Value>) override {
    add({.image = a.image, .sampler = a.image, .sampled = false, .view_type = a.view_type});
    return true;
  }
  std::optional<ir::Address> image_texel(ir::Builder& b, const ImageAccess& a) override {
    add({.image = a.image, .sampler = a.image, .sampled = false, .view_type = a.view_type});
    return ir::Address{.base = b.draw_ptr(), .offset = b.i32(0), .limit = b.i32(0)};
  }
  ir::Value covered(ir::Builder&) override { return {}; }
  std::array<ir::Value, 2> address_ranges(ir::Builder& b) override { return {b.draw_ptr(), b.i32(0)}; }
  ir::Value shared_memory(ir::Builder& b) override { return b.draw_ptr(); }

 private:
  static std::array<ir::Value, 4> texel(ir::Builder& b, ir::Type type) {
    const ir::Value zero = b.zero(type);
    return {zero, zero, zero, zero};
  }
  void add(ImageUse use) {
    use.dynamic = use.image.index || use.sampler.index;
    use.image.index = use.sampler.index = {};
    const bool known = std::ranges::any_of(info_.images, [&](const ImageUse& u) {
      return u.image == use.image && u.sampler == use.sampler && u.sampled == use.sampled && u.view_type == use.view_type &&
             u.dynamic == use.dynamic;
    });
    if (!known) info_.images.push_back(use);
  }

  ModuleInfo& info_;
};

}  // namespace

void reflect(Module& m) {
  ir::Kernel scratch;
  ir::Builder b(scratch);
  Recorder stage(m.info);
  Translator t(m, b, stage);
  t.run();
  m.info.writes_memory = t.found().writes_memory;
  m.info.uses_derivatives = t.found().uses_derivatives;
  m.info.uses_barriers = t.found().uses_barriers;
}

}  // namespace pineda::spirv
