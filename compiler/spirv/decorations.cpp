// OpDecorate, OpMemberDecorate and decoration groups. Decorations that cannot change a result here (RelaxedPrecision, Restrict,
// Aliased, Coherent, Invariant: every operation is invariant by construction ...) are read over.
#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

void apply(Decorations& d, const Instruction& inst, uint32_t at) {
  switch (inst.word_as<spv::Decoration>(at)) {
    case spv::DecorationLocation:
      d.location = inst.word(at + 1);
      break;
    case spv::DecorationComponent:
      d.component = inst.word(at + 1);
      break;
    case spv::DecorationIndex:
      d.index = inst.word(at + 1);
      break;
    case spv::DecorationBuiltIn:
      d.built_in = inst.word(at + 1);
      break;
    case spv::DecorationDescriptorSet:
      d.set = inst.word(at + 1);
      break;
    case spv::DecorationBinding:
      d.binding = inst.word(at + 1);
      break;
    case spv::DecorationSpecId:
      d.spec_id = inst.word(at + 1);
      break;
    case spv::DecorationArrayStride:
      d.array_stride = inst.word(at + 1);
      break;
    case spv::DecorationMatrixStride:
      d.matrix_stride = inst.word(at + 1);
      break;
    case spv::DecorationOffset:
      d.offset = inst.word(at + 1);
      break;
    case spv::DecorationFPRoundingMode:
      d.rounding_mode = inst.word_as<spv::FPRoundingMode>(at + 1);
      break;
    case spv::DecorationFlat:
      d.flat = true;
      break;
    case spv::DecorationNoPerspective:
      d.no_perspective = true;
      break;
    case spv::DecorationCentroid:
      d.centroid = true;
      break;
    case spv::DecorationSample:
      d.sample = true;
      break;
    case spv::DecorationRowMajor:
      d.row_major = true;
      break;
    case spv::DecorationColMajor:
      d.row_major = false;
      break;
    case spv::DecorationBufferBlock:
      d.buffer_block = true;
      break;
    case spv::DecorationNonWritable:
      d.non_writable = true;
      break;
    case spv::DecorationNoContraction:
      d.no_contraction = true;
      break;
    case spv::DecorationXfbBuffer:
    case spv::DecorationXfbStride:
      inst.fail("transform feedback is not supported");
    default:
      break;
  }
}

void merge(Decorations& to, const Decorations& from) {
  const auto take = [](std::optional<uint32_t>& a, const std::optional<uint32_t>& b) {
    if (b) a = b;
  };
  take(to.location, from.location);
  take(to.component, from.component);
  take(to.index, from.index);
  take(to.built_in, from.built_in);
  take(to.set, from.set);
  take(to.binding, from.binding);
  take(to.spec_id, from.spec_id);
  take(to.array_stride, from.array_stride);
  take(to.matrix_stride, from.matrix_stride);
  take(to.offset, from.offset);
  if (from.rounding_mode) to.rounding_mode = from.rounding_mode;
  to.flat |= from.flat;
  to.no_perspective |= from.no_perspective;
  to.centroid |= from.centroid;
  to.sample |= from.sample;
  to.row_major |= from.row_major;
  to.buffer_block |= from.buffer_block;
  to.non_writable |= from.non_writable;
  to.no_contraction |= from.no_contraction;
}

}  // namespace

void decorate(Module& m, const Instruction& inst) {
  switch (inst.op()) {
    case spv::OpDecorate:
    case spv::OpDecorateId:
      apply(m.decorations[inst.word(1)], inst, 2);
      break;
    case spv::OpMemberDecorate:
      apply(m.member_decorations[Module::member_key(inst.word(1), inst.word(2))], inst, 3);
      break;
    case spv::OpGroupDecorate:
      for (uint32_t target : inst.from(2)) merge(m.decorations[target], Decorations(m.decorations_of(inst.word(1))));
      break;
    case spv::OpGroupMemberDecorate:
      for (uint32_t i = 2; i < inst.size(); i += 2) {
        merge(m.member_decorations[Module::member_key(inst.word(i), inst.word(i + 1))],
              Decorations(m.decorations_of(inst.word(1))));
      }
      break;
    default:
      break;
  }
}

}  // namespace pineda::spirv
