#include "tools/fuzz/shapes.h"

#include <algorithm>
#include <initializer_list>

#define SPV_ENABLE_UTILITY_CODE
#include <spirv/unified1/spirv.hpp>

namespace pineda::fuzz {
namespace {

// Writes a module whose main() loads x from a buffer into a Function variable, runs a body, and stores x.
class Assembler {
 public:
  Assembler() {
    inst(spv::OpCapability, {spv::CapabilityShader});
    inst(spv::OpMemoryModel, {spv::AddressingModelLogical, spv::MemoryModelGLSL450});
    inst(spv::OpEntryPoint, {spv::ExecutionModelGLCompute, main_, 0x6e69616d, 0, index_});  // "main"
    inst(spv::OpExecutionMode, {main_, spv::ExecutionModeLocalSize, 16, 1, 1});
    inst(spv::OpDecorate, {index_, spv::DecorationBuiltIn, spv::BuiltInLocalInvocationIndex});
    inst(spv::OpDecorate, {array_, spv::DecorationArrayStride, 4});
    inst(spv::OpMemberDecorate, {block_, 0, spv::DecorationOffset, 0});
    inst(spv::OpDecorate, {block_, spv::DecorationBufferBlock});
    inst(spv::OpDecorate, {data_, spv::DecorationDescriptorSet, 0});
    inst(spv::OpDecorate, {data_, spv::DecorationBinding, 0});
    inst(spv::OpTypeVoid, {void_});
    inst(spv::OpTypeFunction, {function_type_, void_});
    inst(spv::OpTypeInt, {uint_, 32, 0});
    inst(spv::OpTypeBool, {bool_});
    inst(spv::OpTypeRuntimeArray, {array_, uint_});
    inst(spv::OpTypeStruct, {block_, array_});
    const uint32_t p_block = id(), p_in = id();
    inst(spv::OpTypePointer, {p_block, spv::StorageClassUniform, block_});
    inst(spv::OpTypePointer, {p_uint_, spv::StorageClassUniform, uint_});
    inst(spv::OpTypePointer, {p_in, spv::StorageClassInput, uint_});
    inst(spv::OpTypePointer, {p_local_, spv::StorageClassFunction, uint_});
    p_private_ = id();
    inst(spv::OpTypePointer, {p_private_, spv::StorageClassPrivate, uint_});
    inst(spv::OpVariable, {p_block, data_, spv::StorageClassUniform});
    inst(spv::OpVariable, {p_in, index_, spv::StorageClassInput});
    inst(spv::OpVariable, {p_private_, x_, spv::StorageClassPrivate});
    for (uint32_t i = 0; i < kConstants; ++i) inst(spv::OpConstant, {uint_, constants_ + i, i});
  }

  uint32_t id() { return next_++; }
  uint32_t constant(uint32_t i) const { return constants_ + i % kConstants; }

  void inst(spv::Op op, std::initializer_list<uint32_t> operands) {
    words_.push_back(static_cast<uint32_t>(operands.size() + 1) << 16 | op);
    words_.insert(words_.end(), operands);
  }
  void inst(spv::Op op, const std::vector<uint32_t>& operands) {
    words_.push_back(static_cast<uint32_t>(operands.size() + 1) << 16 | op);
    words_.insert(words_.end(), operands.begin(), operands.end());
  }

  uint32_t begin_function() {
    const uint32_t f = id();
    inst(spv::OpFunction, {void_, f, spv::FunctionControlMaskNone, function_type_});
    label(id());
    return f;
  }
  void end_function() {
    inst(spv::OpReturn, {});
    inst(spv::OpFunctionEnd, {});
  }
  void call(uint32_t f) { inst(spv::OpFunctionCall, {void_, id(), f}); }

  // main: x = data[lane]; work(); data[lane] = x
  std::vector<uint32_t> finish(uint32_t work) {
    inst(spv::OpFunction, {void_, main_, spv::FunctionControlMaskNone, function_type_});
    label(id());
    const uint32_t lane = id(), at = id(), x = id(), y = id();
    inst(spv::OpLoad, {uint_, lane, index_});
    inst(spv::OpAccessChain, {p_uint_, at, data_, constant(0), lane});
    inst(spv::OpLoad, {uint_, x, at});
    inst(spv::OpStore, {x_, x});
    call(work);
    inst(spv::OpLoad, {uint_, y, x_});
    inst(spv::OpStore, {at, y});
    end_function();
    std::vector<uint32_t> out{spv::MagicNumber, 0x00010000, 0, next_, 0};
    out.insert(out.end(), words_.begin(), words_.end());
    return out;
  }

  void label(uint32_t l) { inst(spv::OpLabel, {l}); }
  void branch(uint32_t l) { inst(spv::OpBranch, {l}); }

  // x = (x op c) op (x >> 7): five instructions that no optimiser shortens
  void step(uint32_t k) {
    const uint32_t x = id(), a = id(), shifted = id(), c = id();
    inst(spv::OpLoad, {uint_, x, x_});
    inst(k % 3 == 0 ? spv::OpIMul : k % 3 == 1 ? spv::OpIAdd : spv::OpBitwiseXor, {uint_, a, x, constant(2 * k + 3)});
    inst(spv::OpShiftRightLogical, {uint_, shifted, x, constant(7)});
    inst(k % 2 == 0 ? spv::OpIAdd : spv::OpBitwiseXor, {uint_, c, a, shifted});
    inst(spv::OpStore, {x_, c});
  }
  // (x & c) == 0
  uint32_t test(uint32_t k) {
    const uint32_t x = id(), masked = id(), is_zero = id();
    inst(spv::OpLoad, {uint_, x, x_});
    inst(spv::OpBitwiseAnd, {uint_, masked, x, constant(k % 60 + 1)});
    inst(spv::OpIEqual, {bool_, is_zero, masked, constant(0)});
    return is_zero;
  }
  uint32_t x() {
    const uint32_t v = id();
    inst(spv::OpLoad, {uint_, v, x_});
    return v;
  }
  // if (test) then();
  template <typename Fn>
  void if_then(uint32_t k, Fn then) {
    const uint32_t cond = test(k), inside = id(), merge = id();
    inst(spv::OpSelectionMerge, {merge, spv::SelectionControlMaskNone});
    inst(spv::OpBranchConditional, {cond, inside, merge});
    label(inside);
    if (then()) branch(merge);
    label(merge);
  }

 private:
  static constexpr uint32_t kConstants = 64;
  std::vector<uint32_t> words_;
  uint32_t next_ = 1;
  const uint32_t main_ = id(), index_ = id(), array_ = id(), block_ = id(), data_ = id(), void_ = id(), function_type_ = id(),
                 uint_ = id(), bool_ = id(), p_uint_ = id(), p_local_ = id(), x_ = id();
  uint32_t p_private_ = 0;
  const uint32_t constants_ = (next_ += kConstants) - kConstants;
};

std::vector<uint32_t> straight(uint32_t n) {
  Assembler a;
  const uint32_t work = a.begin_function();
  for (uint32_t i = 0; i < n / 5; ++i) a.step(i);
  a.end_function();
  return a.finish(work);
}

std::vector<uint32_t> ifs(uint32_t n) {
  Assembler a;
  const uint32_t work = a.begin_function();
  for (uint32_t i = 0; i < n / 50; ++i) {
    a.if_then(i, [&] {
      for (uint32_t k = 0; k < 8; ++k) a.step(i + k);
      return true;
    });
  }
  a.end_function();
  return a.finish(work);
}

std::vector<uint32_t> early_returns(uint32_t n) {
  Assembler a;
  const uint32_t work = a.begin_function();
  for (uint32_t i = 0; i < n / 50; ++i) {
    a.if_then(i, [&] {
      a.step(i);
      a.inst(spv::OpReturn, {});
      return false;
    });
    for (uint32_t k = 0; k < 8; ++k) a.step(i + k);
  }
  a.end_function();
  return a.finish(work);
}

std::vector<uint32_t> switch_cases(uint32_t n) {
  Assembler a;
  const uint32_t work = a.begin_function();
  const uint32_t cases = n / 100, selector = a.x(), merge = a.id();
  std::vector<uint32_t> labels(cases), operands{selector, merge};
  for (uint32_t i = 0; i < cases; ++i) {
    labels[i] = a.id();
    operands.insert(operands.end(), {i, labels[i]});
  }
  a.inst(spv::OpSelectionMerge, {merge, spv::SelectionControlMaskNone});
  a.inst(spv::OpSwitch, operands);
  for (uint32_t i = 0; i < cases; ++i) {
    a.label(labels[i]);
    for (uint32_t k = 0; k < 20; ++k) a.step(i + k);
    a.branch(i % 7 == 0 && i + 1 < cases ? labels[i + 1] : merge);  // some fall through
  }
  a.label(merge);
  a.end_function();
  return a.finish(work);
}

std::vector<uint32_t> calls(uint32_t n) {
  Assembler a;
  const uint32_t callee = a.begin_function();
  for (uint32_t i = 0; i < 40; ++i) a.step(i);
  a.if_then(3, [&] {
    a.step(1);
    return true;
  });
  a.end_function();
  const uint32_t work = a.begin_function();
  for (uint32_t i = 0; i < n / 200; ++i) a.call(callee);
  a.end_function();
  return a.finish(work);
}

std::vector<uint32_t> loops(uint32_t n) {
  Assembler a;
  const uint32_t work = a.begin_function();
  for (uint32_t i = 0; i < n / 50; ++i) {
    const uint32_t header = a.id(), body = a.id(), next = a.id(), merge = a.id();
    a.branch(header);
    a.label(header);
    const uint32_t cond = a.test(i);
    a.inst(spv::OpLoopMerge, {merge, next, spv::LoopControlMaskNone});
    a.inst(spv::OpBranchConditional, {cond, body, merge});
    a.label(body);
    for (uint32_t k = 0; k < 8; ++k) a.step(i + k);
    a.branch(next);
    a.label(next);
    a.branch(header);
    a.label(merge);
  }
  a.end_function();
  return a.finish(work);
}

// Ifs in Ifs, as deep as SPIR-V allows; what is left of the size stands at the bottom.
void nest(Assembler& a, uint32_t depth, uint32_t steps) {
  if (depth == 0) return;
  a.if_then(depth, [&] {
    for (uint32_t k = 0; k < steps; ++k) a.step(depth + k);
    nest(a, depth - 1, steps);
    return true;
  });
}

std::vector<uint32_t> nests(uint32_t n) {
  constexpr uint32_t kMaxDepth = 1000;
  Assembler a;
  const uint32_t work = a.begin_function();
  const uint32_t depth = std::min(n / 50, kMaxDepth);
  nest(a, depth, n / depth / 6);
  a.end_function();
  return a.finish(work);
}

constexpr Shape kShapes[] = {
    {"straight", straight}, {"ifs", ifs},     {"early returns", early_returns}, {"switch", switch_cases}, {"calls", calls},
    {"loops", loops},       {"nests", nests},
};

}  // namespace

std::span<const Shape> shapes() { return kShapes; }

}  // namespace pineda::fuzz
