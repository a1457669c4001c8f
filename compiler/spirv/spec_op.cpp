// OpSpecConstantOp: the operation is translated as it would be in a function, by the same handlers, and evaluated by the IR's own
// semantics. So every operation means the same in both places, at every width.
#include <algorithm>
#include <array>

#include "base/abi.h"
#include "compiler/ir/semantics.h"
#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

// Those that SPIR-V 3.52.7 allows under the Shader capability.
constexpr spv::Op kAllowed[] = {
    spv::OpSConvert,
    spv::OpUConvert,
    spv::OpFConvert,
    spv::OpSNegate,
    spv::OpNot,
    spv::OpIAdd,
    spv::OpISub,
    spv::OpIMul,
    spv::OpUDiv,
    spv::OpSDiv,
    spv::OpUMod,
    spv::OpSRem,
    spv::OpSMod,
    spv::OpBitwiseOr,
    spv::OpBitwiseXor,
    spv::OpBitwiseAnd,
    spv::OpShiftRightLogical,
    spv::OpShiftLeftLogical,
    spv::OpVectorShuffle,
    spv::OpShiftRightArithmetic,
    spv::OpCompositeExtract,
    spv::OpCompositeInsert,
    spv::OpLogicalOr,
    spv::OpLogicalAnd,
    spv::OpLogicalNot,
    spv::OpLogicalEqual,
    spv::OpLogicalNotEqual,
    spv::OpSelect,
    spv::OpIEqual,
    spv::OpINotEqual,
    spv::OpULessThan,
    spv::OpSLessThan,
    spv::OpUGreaterThan,
    spv::OpSGreaterThan,
    spv::OpULessThanEqual,
    spv::OpSLessThanEqual,
    spv::OpUGreaterThanEqual,
    spv::OpSGreaterThanEqual,
    spv::OpQuantizeToF16,
};

// A stage that has nothing: the operations above need nothing.
class EmptyStage final : public StageInterface {
 public:
  ir::Value input(ir::Builder&, const InterfaceScalar&) override { return {}; }
  void output(ir::Builder&, const InterfaceScalar&, ir::Value) override {}
  std::optional<BufferRef> buffer(ir::Builder&, uint32_t, uint32_t, ir::Value) override { return {}; }
  std::optional<std::array<ir::Value, 4>> sample(ir::Builder&, const SampleRequest&) override { return {}; }
  std::optional<std::array<ir::Value, 4>> query(ir::Builder&, const ImageQuery&) override { return {}; }
  std::optional<std::array<ir::Value, 4>> image_load(ir::Builder&, const ImageAccess&) override { return {}; }
  bool image_store(ir::Builder&, const ImageAccess&, std::span<const ir::Value>) override { return false; }
  ir::Value covered(ir::Builder&) override { return {}; }
  ir::Value shared_memory(ir::Builder&) override { return {}; }
};

// The value of each instruction of a straight list of constants and pure operations.
std::vector<uint64_t> evaluate(const ir::Kernel& kernel, const Instruction& inst) {
  std::vector<uint64_t> value(kernel.insts.size());
  for (ir::Value v : kernel.regions[kernel.wave].insts) {
    const ir::Inst& i = kernel.at(v);
    if (i.op == ir::Op::kConst) {
      value[v.id] = ir::const_raw(i.type, i.imm, ir::Floats::kNative);
      continue;
    }
    const ir::Type operand = kernel.at(i.operand[i.op == ir::Op::kSelect ? 1 : 0]).type;
    const ir::LaneFn fn = ir::lane_fn(i.op, i.type, operand, ir::Floats::kNative);
    if (!fn) inst.fail("cannot be folded");
    std::array<std::array<uint64_t, kLanes>, 4> lanes{};
    for (uint32_t k = 0; k < 3; ++k) lanes[k].fill(value[i.operand[k].id]);
    fn(lanes[3].data(), lanes[0].data(), lanes[1].data(), lanes[2].data());
    value[v.id] = lanes[3][0];
  }
  return value;
}

}  // namespace

Constant fold_spec_op(const Module& m, const Instruction& inst) {
  const auto op = inst.word_as<spv::Op>(3);
  inst.word(4);  // every operation has an operand
  if (std::ranges::find(kAllowed, op) == std::end(kAllowed)) inst.fail(op_name(op) + " is not allowed here");
  for (const ir::Type type : m.flat_scalars(inst.word(1))) {
    const bool computes = op == spv::OpFConvert || op == spv::OpQuantizeToF16 || op == spv::OpSelect;
    const bool moves = op == spv::OpCompositeExtract || op == spv::OpCompositeInsert || op == spv::OpVectorShuffle;
    if (ir::is_float(type) && !computes && !moves) inst.fail("float arithmetic is not allowed here");
  }
  // The operation as an instruction of its own: its result type and id, then its operands.
  std::vector<uint32_t> words{(inst.size() - 1) << 16 | static_cast<uint32_t>(op), inst.word(1), inst.word(2)};
  words.insert(words.end(), inst.from(4).begin(), inst.from(4).end());
  const Instruction operation(words, inst.offset_words());
  ir::Kernel kernel;
  ir::Builder b(kernel);
  EmptyStage stage;
  const Values values = Translator(m, b, stage).constant_result(operation);
  const std::vector<uint64_t> known = evaluate(kernel, inst);
  Constant c{.type = inst.word(1)};
  for (ir::Value v : values) c.scalars.push_back(known[v.id]);
  return c;
}

}  // namespace pineda::spirv
