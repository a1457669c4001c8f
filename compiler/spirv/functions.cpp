// Functions and their blocks: the structure that flow.cpp walks. Only form is checked here; whether the graph is structured shows
// when it is walked.
#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

bool is_terminator(spv::Op op) {
  switch (op) {
    case spv::OpBranch:
    case spv::OpBranchConditional:
    case spv::OpSwitch:
    case spv::OpReturn:
    case spv::OpReturnValue:
    case spv::OpKill:
    case spv::OpTerminateInvocation:
    case spv::OpUnreachable:
      return true;
    default:
      return false;
  }
}

class FunctionReader {
 public:
  explicit FunctionReader(Module& m) : m_(m) {}

  void run() {
    bool inside = false;
    for (at_ = 0; at_ < m_.instructions.size(); ++at_) {
      const Instruction& inst = m_.instructions[at_];
      if (inst.op() == spv::OpFunction) {
        if (inside) inst.fail("functions cannot be nested");
        begin(inst);
        inside = true;
      } else if (inst.op() == spv::OpFunctionEnd) {
        if (!inside || open_) inst.fail("stands outside a function or inside a block");
        finish();
        inside = false;
      } else if (inside) {
        body(inst);
      }
    }
    if (inside) fail("The module ends inside a function.");
  }

 private:
  void begin(const Instruction& inst) {
    function_ = {.id = inst.word(2), .result_type = m_.type(inst.word(1)).id, .first = at_};
    const Type& type = m_.type(inst.word(4));
    if (type.kind != TypeKind::kFunction || type.element != function_.result_type) inst.fail("the function type does not fit");
    parameter_types_ = type.members;
  }

  void body(const Instruction& inst) {
    if (inst.op() == spv::OpLine || inst.op() == spv::OpNoLine) return;
    if (inst.op() == spv::OpFunctionParameter) {
      const size_t index = function_.parameters.size();
      const bool fits = function_.blocks.empty() && index < parameter_types_.size() && parameter_types_[index] == inst.word(1);
      if (!fits) inst.fail("does not fit the function's type");
      function_.parameters.push_back(inst.word(2));
    } else if (inst.op() == spv::OpLabel) {
      if (open_) inst.fail("the block before has no terminator");
      open_ = true;
      const auto index = static_cast<uint32_t>(function_.blocks.size());
      if (!function_.block_index.emplace(inst.word(1), index).second) inst.fail("the label is used twice");
      function_.blocks.push_back({.label = inst.word(1), .first = at_ + 1});
    } else {
      if (!open_) inst.fail("stands outside a block");
      in_block(inst);
    }
  }

  void in_block(const Instruction& inst) {
    Block& block = function_.blocks.back();
    if (block.merge_kind != MergeKind::kNone && !is_terminator(inst.op())) inst.fail("stands behind a merge instruction");
    if (inst.op() == spv::OpSelectionMerge || inst.op() == spv::OpLoopMerge) {
      block.merge_kind = inst.op() == spv::OpLoopMerge ? MergeKind::kLoop : MergeKind::kSelection;
      block.merge = inst.word(1);
      if (block.merge_kind == MergeKind::kLoop) block.continue_target = inst.word(2);
    } else if (inst.op() == spv::OpVariable) {
      if (inst.word(3) != spv::StorageClassFunction) inst.fail("only Function variables stand in functions");
      declare_variable(m_, inst);
    } else if (is_terminator(inst.op())) {
      block.terminator = at_;
      open_ = false;
    }
  }

  void add_edge(const Instruction& inst, uint32_t label) {
    const auto found = function_.block_index.find(label);
    if (found == function_.block_index.end()) inst.fail("%" + std::to_string(label) + " is not a block of this function");
    ++function_.blocks[found->second].predecessors;
  }

  void finish() {
    if (function_.parameters.size() != parameter_types_.size()) {
      m_.instructions[function_.first].fail("does not have the parameters of its type");
    }
    uint32_t returns = 0, dead_ends = 0;
    for (const Block& block : function_.blocks) {
      const Instruction& end = m_.instructions[block.terminator];
      switch (end.op()) {
        case spv::OpReturn:
        case spv::OpReturnValue:
          ++returns;
          break;
        case spv::OpKill:
        case spv::OpTerminateInvocation:
        case spv::OpUnreachable:
          ++dead_ends;
          break;
        case spv::OpBranch:
          add_edge(end, end.word(1));
          break;
        case spv::OpBranchConditional:
          add_edge(end, end.word(2));
          add_edge(end, end.word(3));
          break;
        case spv::OpSwitch:
          add_edge(end, end.word(2));
          for (const SwitchCase& c : switch_cases(m_, end)) add_edge(end, c.label);
          break;
        default:
          break;
      }
      if (block.merge_kind != MergeKind::kNone && !function_.block_index.contains(block.merge))
        end.fail("the merge block is missing");
      if (block.merge_kind == MergeKind::kLoop && !function_.block_index.contains(block.continue_target)) {
        end.fail("the continue target is missing");
      }
    }
    // A single return without dead ends beside it stands at the end: every construct's merge block leads there.
    function_.returns_early = returns > 1 || dead_ends > 0;
    function_.parameter_steps.resize(function_.parameters.size());
    function_.written_parameters.resize(function_.parameters.size());
    const uint32_t id = function_.id;
    m_.functions[id] = std::move(function_);
    function_ = {};
  }

  Module& m_;
  uint32_t at_ = 0;
  Function function_;
  std::vector<uint32_t> parameter_types_;
  bool open_ = false;  // between OpLabel and its terminator
};

}  // namespace

std::vector<SwitchCase> switch_cases(const Module& m, const Instruction& inst) {
  const Type& selector = m.type(m.type_of(inst.word(1)));
  if (selector.kind != TypeKind::kInt) inst.fail("the selector is not an integer");
  const bool is_wide = selector.scalar == ir::Type::kI64;  // then a literal takes two words, the low one first
  std::vector<SwitchCase> out;
  for (uint32_t i = 3; i < inst.size(); i += is_wide ? 3 : 2) {
    const uint64_t literal = is_wide ? inst.word(i) | uint64_t{inst.word(i + 1)} << 32 : inst.word(i);
    out.push_back({literal, inst.word(is_wide ? i + 2 : i + 1)});
  }
  return out;
}

void read_functions(Module& m) { FunctionReader(m).run(); }

}  // namespace pineda::spirv
