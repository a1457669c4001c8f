// OpImageQuery*: what StageInterface::query answers, cut to what the shader asked for.
#include "compiler/spirv/image.h"

namespace pineda::spirv {
namespace {

Texel ask(Translator& t, const Instruction& inst, const ImageQuery& query) {
  const std::optional<Texel> answer = t.stage.query(t.b, query);
  if (!answer) inst.fail("this query is not supported");
  return *answer;
}

ImageQuery query_for(Translator& t, const Instruction& inst, ImageQuery::Kind kind) {
  const Opaque o = t.opaque(inst, 3);
  ImageQuery q{.kind = kind, .image = o.image};
  q.sampler = o.has_sampler ? o.sampler : o.image;
  q.view_type = view_type(image_type(t, inst, o));
  return q;
}

void size_of(Translator& t, const Instruction& inst, ir::Value lod) {
  ImageQuery q = query_for(t, inst, ImageQuery::Kind::kSize);
  q.lod = lod;
  const Texel answer = ask(t, inst, q);
  const ImageType& image = image_type(t, inst, t.opaque(inst, 3));
  const uint32_t dims = image.dim == spv::DimCube ? 2 : dimensions(image);
  Values out(answer.begin(), answer.begin() + dims);
  if (image.arrayed) out.push_back(image.dim == spv::DimCube ? t.b.udiv(answer[3], t.b.i32(6)) : answer[3]);
  t.define(inst, std::move(out));
}

void query_size_lod(Translator& t, const Instruction& inst) { size_of(t, inst, t.scalar(inst, 4, ir::Type::kI32)); }
void query_size(Translator& t, const Instruction& inst) { size_of(t, inst, {}); }

void query_levels(Translator& t, const Instruction& inst) {
  t.define(inst, Values{ask(t, inst, query_for(t, inst, ImageQuery::Kind::kLevels))[0]});
}

void query_samples(Translator& t, const Instruction& inst) {
  t.define(inst, Values{ask(t, inst, query_for(t, inst, ImageQuery::Kind::kSamples))[0]});
}

void query_lod(Translator& t, const Instruction& inst) {
  if (!t.is_fragment()) inst.fail("needs a fragment shader");
  t.found().uses_derivatives = true;
  ImageQuery q = query_for(t, inst, ImageQuery::Kind::kLod);
  const Values coord = t.floats(inst, 4);
  const uint32_t dims = dimensions(image_type(t, inst, t.opaque(inst, 3)));
  if (coord.size() < dims) inst.fail("the coordinate has too few components");
  std::copy_n(coord.begin(), dims, q.coord.begin());
  const Texel answer = ask(t, inst, q);
  t.define(inst, Values{answer[0], answer[1]});
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(ImageQuerySizeLod, 5, query_size_lod), PINEDA_SPIRV_ROW(ImageQuerySize, 4, query_size),
    PINEDA_SPIRV_ROW(ImageQueryLevels, 4, query_levels),    PINEDA_SPIRV_ROW(ImageQuerySamples, 4, query_samples),
    PINEDA_SPIRV_ROW(ImageQueryLod, 5, query_lod),
};

}  // namespace

std::span<const OpRow> image_query_rows() { return kRows; }

}  // namespace pineda::spirv
