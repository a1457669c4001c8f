#include "compiler/spirv/opcodes.h"

#include <algorithm>
#include <array>

namespace pineda::spirv {
namespace {

// Read by parse() or flow.cpp; here for their names.
constexpr OpRow kStructureRows[] = {
    PINEDA_SPIRV_ROW(Nop, 1, [](Translator&, const Instruction&) {}),
    PINEDA_SPIRV_ROW(Line, 1, [](Translator&, const Instruction&) {}),
    PINEDA_SPIRV_ROW(NoLine, 1, [](Translator&, const Instruction&) {}),
    PINEDA_SPIRV_ROW(SelectionMerge, 3, [](Translator&, const Instruction&) {}),
    PINEDA_SPIRV_ROW(LoopMerge, 4, [](Translator&, const Instruction&) {}),
    PINEDA_SPIRV_ROW(Phi, 3, [](Translator&, const Instruction& i) { i.fail("must stand at the head of a block"); }),
    PINEDA_SPIRV_ROW(Variable, 4, [](Translator& t, const Instruction& i) { t.declare_local(i); }),
    PINEDA_SPIRV_ROW(Capability, 2, nullptr),
    PINEDA_SPIRV_ROW(MemoryModel, 3, nullptr),
    PINEDA_SPIRV_ROW(EntryPoint, 4, nullptr),
    PINEDA_SPIRV_ROW(ExecutionMode, 3, nullptr),
    PINEDA_SPIRV_ROW(ExecutionModeId, 3, nullptr),
    PINEDA_SPIRV_ROW(Extension, 2, nullptr),
    PINEDA_SPIRV_ROW(ExtInstImport, 3, nullptr),
    PINEDA_SPIRV_ROW(Decorate, 3, nullptr),
    PINEDA_SPIRV_ROW(DecorateId, 3, nullptr),
    PINEDA_SPIRV_ROW(DecorateString, 4, nullptr),
    PINEDA_SPIRV_ROW(MemberDecorateString, 5, nullptr),
    PINEDA_SPIRV_ROW(MemberDecorate, 4, nullptr),
    PINEDA_SPIRV_ROW(DecorationGroup, 2, nullptr),
    PINEDA_SPIRV_ROW(GroupDecorate, 2, nullptr),
    PINEDA_SPIRV_ROW(GroupMemberDecorate, 2, nullptr),
    PINEDA_SPIRV_ROW(TypeVoid, 2, nullptr),
    PINEDA_SPIRV_ROW(TypeBool, 2, nullptr),
    PINEDA_SPIRV_ROW(TypeInt, 4, nullptr),
    PINEDA_SPIRV_ROW(TypeFloat, 3, nullptr),
    PINEDA_SPIRV_ROW(TypeVector, 4, nullptr),
    PINEDA_SPIRV_ROW(TypeMatrix, 4, nullptr),
    PINEDA_SPIRV_ROW(TypeImage, 9, nullptr),
    PINEDA_SPIRV_ROW(TypeSampler, 2, nullptr),
    PINEDA_SPIRV_ROW(TypeSampledImage, 3, nullptr),
    PINEDA_SPIRV_ROW(TypeArray, 4, nullptr),
    PINEDA_SPIRV_ROW(TypeRuntimeArray, 3, nullptr),
    PINEDA_SPIRV_ROW(TypeStruct, 2, nullptr),
    PINEDA_SPIRV_ROW(TypePointer, 4, nullptr),
    PINEDA_SPIRV_ROW(TypeForwardPointer, 3, nullptr),
    PINEDA_SPIRV_ROW(TypeFunction, 3, nullptr),
    PINEDA_SPIRV_ROW(ConstantTrue, 3, nullptr),
    PINEDA_SPIRV_ROW(ConstantFalse, 3, nullptr),
    PINEDA_SPIRV_ROW(Constant, 4, nullptr),
    PINEDA_SPIRV_ROW(ConstantComposite, 3, nullptr),
    PINEDA_SPIRV_ROW(ConstantNull, 3, nullptr),
    PINEDA_SPIRV_ROW(SpecConstantTrue, 3, nullptr),
    PINEDA_SPIRV_ROW(SpecConstantFalse, 3, nullptr),
    PINEDA_SPIRV_ROW(SpecConstant, 4, nullptr),
    PINEDA_SPIRV_ROW(SpecConstantComposite, 3, nullptr),
    PINEDA_SPIRV_ROW(SpecConstantOp, 5, nullptr),
    PINEDA_SPIRV_ROW(Function, 5, nullptr),
    PINEDA_SPIRV_ROW(FunctionParameter, 3, nullptr),
    PINEDA_SPIRV_ROW(FunctionEnd, 1, nullptr),
    PINEDA_SPIRV_ROW(Label, 2, nullptr),
    PINEDA_SPIRV_ROW(Branch, 2, nullptr),
    PINEDA_SPIRV_ROW(BranchConditional, 4, nullptr),
    PINEDA_SPIRV_ROW(Switch, 3, nullptr),
    PINEDA_SPIRV_ROW(Return, 1, nullptr),
    PINEDA_SPIRV_ROW(ReturnValue, 2, nullptr),
    PINEDA_SPIRV_ROW(Kill, 1, nullptr),
    PINEDA_SPIRV_ROW(TerminateInvocation, 1, nullptr),
    PINEDA_SPIRV_ROW(Unreachable, 1, nullptr),
};

// Every instruction that there is, for messages.
struct OpName {
  uint32_t op;
  const char *name, *capabilities;
};
constexpr OpName kNames[] = {
#define PINEDA_SPIRV_OP(value, name, capabilities) {value, name, capabilities},
#define PINEDA_SPIRV_CAPABILITY(value, name)
#include "compiler/spirv/names.inc"
#undef PINEDA_SPIRV_OP
#undef PINEDA_SPIRV_CAPABILITY
};
static_assert(std::ranges::is_sorted(kNames, {}, &OpName::op));

const OpName* find_name(spv::Op op) {
  const auto found = std::ranges::lower_bound(kNames, static_cast<uint32_t>(op), {}, &OpName::op);
  return found != std::end(kNames) && found->op == static_cast<uint32_t>(op) ? &*found : nullptr;
}

constexpr uint32_t kDirect = 512;  // core opcodes; extensions' are above 4000 and few

struct Table {
  std::array<const OpRow*, kDirect> direct{};
  std::vector<const OpRow*> others;

  void add(std::span<const OpRow> rows) {
    for (const OpRow& row : rows) {
      if (static_cast<uint32_t>(row.op) < kDirect)
        direct[row.op] = &row;
      else
        others.push_back(&row);
    }
  }

  Table() {
    add(kStructureRows);
    add(arith_rows());
    add(logic_rows());
    add(composite_rows());
    add(matrix_rows());
    add(memory_rows());
    add(pointer_rows());
    add(dot_product_rows());
    add(atomic_rows());
    add(image_rows());
    add(image_query_rows());
    add(subgroup_rows());
    add(other_rows());
  }
};

}  // namespace

const OpRow* find_op(spv::Op op) {
  static const Table table;
  if (static_cast<uint32_t>(op) < kDirect) return table.direct[op];
  const auto found = std::ranges::find(table.others, op, &OpRow::op);
  return found == table.others.end() ? nullptr : *found;
}

std::string op_name(spv::Op op) {
  const OpName* name = find_name(op);
  return name ? name->name : "opcode " + std::to_string(static_cast<uint32_t>(op));
}

std::string why_unsupported(spv::Op op) {
  const OpName* name = find_name(op);
  if (!name) return "there is no such instruction";
  if (find_op(op)) return "does not belong into a function's body";
  const std::string capabilities = name->capabilities;
  return capabilities.empty() ? "is not supported" : "is not supported (capability " + capabilities + ")";
}

}  // namespace pineda::spirv
