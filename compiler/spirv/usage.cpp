// What the entry point's call tree does with variables, found without translating: which are used, which scalars of outputs are
// written, and by which steps dynamic indices move through Function, Private, Input and Output variables (flat_memory.h).
#include <algorithm>
#include <numeric>

#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

constexpr uint32_t kMaxCallDepth = 64;

class CallGraph {
 public:
  explicit CallGraph(Module& m) : m_(m) {}

  void visit(uint32_t function_id, const Instruction& user, uint32_t depth) {
    if (depth > kMaxCallDepth) user.fail("functions call each other more than 64 deep");
    State& state = state_[function_id];
    if (state == State::kDone) return;
    if (state == State::kOpen) user.fail("recursion is not allowed");
    state = State::kOpen;
    for (const Block& block : m_.function(function_id).blocks) {
      for (uint32_t i = block.first; i < block.terminator; ++i) {
        const Instruction& inst = m_.instructions[i];
        if (inst.op() != spv::OpFunctionCall) continue;
        if (!m_.functions.contains(inst.word(3))) inst.fail("%" + std::to_string(inst.word(3)) + " is not a function");
        visit(inst.word(3), inst, depth + 1);
      }
    }
    state_[function_id] = State::kDone;
    m_.call_order.push_back(function_id);
  }

 private:
  enum class State : uint8_t { kNew, kOpen, kDone };
  Module& m_;
  std::unordered_map<uint32_t, State> state_;
};

// Where a pointer points, as far as it is known statically.
struct Root {
  uint32_t id = 0;    // variable or parameter; 0 = neither
  bool exact = true;  // first is the first scalar
  uint64_t first = 0;
  uint32_t type = 0;  // pointee
};

class FunctionUsage {
 public:
  FunctionUsage(Module& m, Function& f) : m_(m), f_(f) {
    for (uint32_t i = 0; i < f.parameters.size(); ++i) parameter_index_[f.parameters[i]] = i;
  }

  void run() {
    for (const Block& block : f_.blocks) {
      for (uint32_t i = block.first; i <= block.terminator; ++i) instruction(m_.instructions[i]);
    }
  }

 private:
  Root root(uint32_t id) {
    if (const auto found = roots_.find(id); found != roots_.end()) return found->second;
    if (const auto v = m_.variables.find(id); v != m_.variables.end()) {
      v->second.used = true;
      return {.id = id, .type = v->second.pointee};
    }
    if (parameter_index_.contains(id)) {
      const Type& type = m_.type(m_.type_of(id));
      if (type.kind == TypeKind::kPointer) return {.id = id, .type = type.element};
    }
    return {};
  }

  void mark_dynamic(const Root& r, uint64_t step) {
    const auto add = [&](uint32_t& to) { to = static_cast<uint32_t>(std::min<uint64_t>(std::gcd(uint64_t{to}, step), ~0u)); };
    if (const auto v = m_.variables.find(r.id); v != m_.variables.end()) add(v->second.dynamic_step);
    if (const auto p = parameter_index_.find(r.id); p != parameter_index_.end()) add(f_.parameter_steps[p->second]);
  }

  void write(const Root& r, bool whole = false) {
    if (const auto p = parameter_index_.find(r.id); p != parameter_index_.end()) f_.written_parameters[p->second] = true;
    const auto found = m_.variables.find(r.id);
    if (found == m_.variables.end()) return;
    Variable& v = found->second;
    v.written = true;
    if (v.storage != spv::StorageClassOutput) return;
    const uint64_t size = m_.type(v.pointee).scalar_count;
    if (size > kMaxFlatScalars) fail("An output variable has more than 16384 scalars.", v.offset_words);
    v.written_scalars.resize(size);
    const uint64_t first = whole || !r.exact ? 0 : r.first;
    const uint64_t count = whole || !r.exact ? size : m_.type(r.type).scalar_count;
    for (uint64_t i = first; i < std::min(first + count, size); ++i) v.written_scalars[i] = true;
  }

  void access_chain(const Instruction& inst, uint32_t first_index) {
    Root r = root(inst.word(3));
    if (r.id == 0) return;  // the translator reports it if it is reached
    for (uint32_t index_id : inst.from(first_index)) {
      const Type& t = m_.type(r.type);
      const Constant* constant = m_.constant(index_id);
      const uint64_t index = constant && !constant->scalars.empty() ? std::min<uint64_t>(constant->scalars[0], ~0u) : 0;
      if (t.kind == TypeKind::kStruct) {
        if (!constant || index >= t.members.size()) inst.fail("a struct index must be a constant member number");
        r.first += t.first_scalar[index];
        r.type = t.members[index];
      } else {
        if (t.element == 0 || t.is_scalar() || t.kind == TypeKind::kPointer)
          inst.fail("has more indices than its type has levels");
        r.type = t.element;
        if (!constant) {
          mark_dynamic(r, std::max<uint64_t>(m_.type(r.type).scalar_count, 1));
          r.exact = false;
        }
        r.first += index * m_.type(r.type).scalar_count;
      }
    }
    roots_[inst.word(2)] = r;
  }

  void call(const Instruction& inst) {
    const Function& callee = m_.function(inst.word(3));  // analysed before: call_order has callees first
    if (inst.size() - 4 != callee.parameters.size()) inst.fail("has the wrong number of arguments");
    for (uint32_t i = 0; i < callee.parameters.size(); ++i) {
      const Root r = root(inst.word(4 + i));
      if (callee.parameter_steps[i] != 0) mark_dynamic(r, callee.parameter_steps[i]);
      if (callee.written_parameters[i]) write(r, true);
    }
  }

  void instruction(const Instruction& inst) {
    switch (inst.op()) {
      case spv::OpAccessChain:
      case spv::OpInBoundsAccessChain:
        access_chain(inst, 4);
        break;
      case spv::OpPtrAccessChain:
      case spv::OpInBoundsPtrAccessChain:
        access_chain(inst, 5);
        break;
      case spv::OpCopyObject:
        roots_[inst.word(2)] = root(inst.word(3));
        break;
      case spv::OpStore:
        write(root(inst.word(1)));
        root(inst.word(2));
        break;
      case spv::OpCopyMemory:
      case spv::OpCopyMemorySized:
        write(root(inst.word(1)));
        root(inst.word(2));
        break;
      case spv::OpFunctionCall:
        call(inst);
        break;
      case spv::OpExtInst:  // InterpolateAt* has a pointer first; Modf and Frexp write through their second operand
        if (inst.size() > 5) root(inst.word(5));
        if (inst.size() > 6) write(root(inst.word(6)));
        break;
      case spv::OpLoad:
      case spv::OpArrayLength:
      case spv::OpImageTexelPointer:
        root(inst.word(3));
        break;
      case spv::OpAtomicStore:
      case spv::OpReturnValue:
        root(inst.word(1));
        break;
      case spv::OpSelect:  // pointers as values
      case spv::OpPhi:
      case spv::OpPtrEqual:
      case spv::OpPtrNotEqual:
      case spv::OpPtrDiff:
      case spv::OpCompositeConstruct:
      case spv::OpConvertPtrToU:
      case spv::OpBitcast:
        for (uint32_t id : inst.from(3)) root(id);
        break;
      case spv::OpKill:
      case spv::OpTerminateInvocation:
      case spv::OpDemoteToHelperInvocation:
        m_.info.uses_discard = true;
        break;
      default:
        if (inst.op() == spv::OpAtomicFAddEXT || (inst.op() >= spv::OpAtomicLoad && inst.op() <= spv::OpAtomicXor))
          root(inst.word(3));
        break;
    }
  }

  Module& m_;
  Function& f_;
  std::unordered_map<uint32_t, uint32_t> parameter_index_;
  std::unordered_map<uint32_t, Root> roots_;
};

}  // namespace

void find_usage(Module& m) {
  CallGraph(m).visit(m.entry_point, m.instructions[m.function(m.entry_point).first], 0);
  for (uint32_t id : m.call_order) FunctionUsage(m, m.functions.at(id)).run();
  if (!m.function(m.entry_point).parameters.empty()) fail("The entry point has parameters.");
}

}  // namespace pineda::spirv
