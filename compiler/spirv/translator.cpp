#include "compiler/spirv/translator.h"

#include <algorithm>
#include <bit>

#include "base/deep_stack.h"
#include "compiler/ir/semantics.h"
#include "compiler/spirv/flow.h"
#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {

// ---- what ids stand for ---------------------------------------------------------------------------------------------------

Translator::Record& Translator::record(const Instruction& inst, uint32_t id) {
  const uint32_t index = id < m.definition.size() ? m.definition[id] : 0;
  if (index == 0 || index > records_.size() || records_[index - 1].kind == RecordKind::kNone) {
    inst.fail("%" + std::to_string(id) + " is not defined before it is used");
  }
  return records_[index - 1];
}

Translator::Record& Translator::fresh(const Instruction& inst) {
  const uint32_t index = m.definition[inst.word(2)];  // parse() checked the id
  Record& r = records_[index - 1];
  r = Record();
  r.region = b.region();
  return r;
}

// A value of a region that is closed by now reaches us through variables. They are set at the region's end: its lanes there are
// those that made the value, and in a loop the last iteration wins, which is what SPIR-V's dominance rule means.
void Translator::escape(const Instruction& inst, Record& r) {
  const ir::RegionId here = b.region();
  const auto insts = [&]() -> std::vector<ir::Value>& { return b.kernel().regions[r.region].insts; };
  const ir::Value yield = insts().back();
  insts().pop_back();
  b.set_region(r.region);
  for (ir::Value v : r.values) {
    ir::Var var;
    if (v) {
      var = variable(inst, b.type(v));
      b.set(var, v);
    }
    r.escaped.push_back(var);
  }
  insts().push_back(yield);
  b.set_region(here);
}

bool Translator::is_open(ir::RegionId region) const { return std::find(open_.rbegin(), open_.rend(), region) != open_.rend(); }

Values Translator::usable(const Instruction& inst, Record& r) {
  if (is_open(r.region)) return r.values;
  if (r.escaped.empty() && !r.values.empty()) escape(inst, r);
  Values out(r.values.size());
  for (size_t i = 0; i < out.size(); ++i) {
    if (r.values[i]) out[i] = b.get(r.escaped[i]);
  }
  return out;
}

Values Translator::constant_values(const Constant& constant) {
  Values out;
  const std::vector<ir::Type> types = m.flat_scalars(constant.type);
  out.reserve(types.size());
  for (size_t i = 0; i < types.size(); ++i) {
    const uint64_t bits = constant.scalars.empty() ? 0 : constant.scalars[i];
    out.push_back(literal(types[i], bits));
  }
  return out;
}

ir::Value Translator::literal(ir::Type type, uint64_t bits) {
  if (!ir::is_float(type)) return b.constant(type, bits);
  return b.fconst(type, std::bit_cast<double>(ir::const_imm(type, bits, ir::Floats::kNative)));
}

// ---- operands -------------------------------------------------------------------------------------------------------------

Values Translator::values(const Instruction& inst, uint32_t word) {
  const uint32_t id = inst.word(word);
  if (const Constant* c = m.constant(id)) return constant_values(*c);
  Record& r = record(inst, id);
  if (r.kind == RecordKind::kPointer && m.type(pointers_[r.detail].type).is_value) return pointer_values(inst, word);
  if (r.kind != RecordKind::kValues) inst.fail("%" + std::to_string(id) + " is not a value");
  return usable(inst, r);
}

Values Translator::typed(const Instruction& inst, uint32_t word, bool (*accept)(ir::Type), const char* what) {
  Values out = values(inst, word);
  const Type& type = type_of(inst, word);
  const bool shape = type.is_scalar() || type.kind == TypeKind::kVector;
  if (!shape || !accept(b.type(out[0]))) inst.fail("%" + std::to_string(inst.word(word)) + " is not " + what);
  return out;
}

Values Translator::floats(const Instruction& inst, uint32_t word) {
  return typed(inst, word, ir::is_float, "a float scalar or vector");
}
Values Translator::integers(const Instruction& inst, uint32_t word) {
  return typed(inst, word, ir::is_int, "an integer scalar or vector");
}
Values Translator::bools(const Instruction& inst, uint32_t word) {
  return typed(
      inst, word, [](ir::Type t) { return t == ir::Type::kB1; }, "a bool scalar or vector");
}

ir::Value Translator::scalar(const Instruction& inst, uint32_t word, ir::Type type) {
  const Values v = values(inst, word);
  if (v.size() != 1 || b.type(v[0]) != type || !type_of(inst, word).is_scalar()) {
    inst.fail("%" + std::to_string(inst.word(word)) + " is not a scalar " + ir::type_name(type));
  }
  return v[0];
}

ir::Value Translator::index(const Instruction& inst, uint32_t word) {
  const Type& type = type_of(inst, word);
  if (type.kind != TypeKind::kInt) inst.fail("%" + std::to_string(inst.word(word)) + " is not an integer");
  const ir::Value v = values(inst, word)[0];
  switch (b.type(v)) {
    case ir::Type::kI32:
      return v;
    case ir::Type::kI64:  // saturated, so that it stays out of range
      return b.convert(ir::Op::kTrunc, ir::Type::kI32, b.umin(v, b.i64(~0u)));
    default:
      return b.convert(type.is_signed ? ir::Op::kSExt : ir::Op::kZExt, ir::Type::kI32, v);
  }
}

Pointer Translator::pointer(const Instruction& inst, uint32_t word) {
  const uint32_t id = inst.word(word);
  if (m.constant(id)) return pointer_from_values(inst, word);
  Record& r = record(inst, id);
  if (r.kind == RecordKind::kValues) return pointer_from_values(inst, word);
  if (r.kind != RecordKind::kPointer) inst.fail("%" + std::to_string(id) + " is not a pointer");
  const Values dynamic = usable(inst, r);
  Pointer p = pointers_[r.detail];
  p.index = dynamic[0];
  p.descriptor_index = dynamic[1];
  p.base = dynamic[2];
  p.size_bytes = dynamic[3];
  p.in_range = dynamic[4];
  return p;
}

Opaque Translator::opaque(const Instruction& inst, uint32_t word) {
  Record& r = record(inst, inst.word(word));
  if (r.kind != RecordKind::kOpaque) inst.fail("%" + std::to_string(inst.word(word)) + " is not an image or sampler");
  const Values dynamic = usable(inst, r);
  Opaque o = opaques_[r.detail];
  o.image.index = dynamic[0];
  o.sampler.index = dynamic[1];
  return o;
}

ir::Type Translator::component_of(const Type& type) const {
  const Type* t = &type;
  while (t->kind == TypeKind::kVector || t->kind == TypeKind::kMatrix) t = &m.type(t->element);
  return t->scalar;
}

// ---- results --------------------------------------------------------------------------------------------------------------

void Translator::check_result(const Instruction& inst, const Values& values) const {
  const Type& type = m.type(inst.word(1));
  if (!type.is_value || type.scalar_count != values.size()) inst.fail("the result does not have its type's size");
  if (type.is_scalar() || type.kind == TypeKind::kVector) {
    const ir::Type wanted = type.is_scalar() ? type.scalar : m.type(type.element).scalar;
    for (ir::Value v : values) {
      if (b.type(v) != wanted) inst.fail("the result does not have its type");
    }
    return;
  }
  const std::vector<ir::Type> wanted = m.flat_scalars(type.id);
  for (size_t i = 0; i < values.size(); ++i) {
    if (b.type(values[i]) != wanted[i]) inst.fail("the result does not have its type");
  }
}

void Translator::define(const Instruction& inst, Values values) {
  check_result(inst, values);
  if (constant_result_) {
    *constant_result_ = std::move(values);
    return;
  }
  value_scalars_ += static_cast<uint32_t>(values.size());
  if (value_scalars_ > kMaxValueScalars) inst.fail("the shader has too many values");
  Record& r = fresh(inst);
  r.kind = RecordKind::kValues;
  r.values = std::move(values);
}

void Translator::define(const Instruction& inst, const Pointer& pointer) {
  const Type& type = result_type(inst);
  if (type.kind != TypeKind::kPointer || type.element != pointer.pointee || type.storage != pointer.storage) {
    inst.fail("the result type does not fit what is pointed to");
  }
  Record& r = fresh(inst);
  r.kind = RecordKind::kPointer;
  r.values = {pointer.index, pointer.descriptor_index, pointer.base, pointer.size_bytes, pointer.in_range};
  r.detail = static_cast<uint32_t>(pointers_.size());
  pointers_.push_back(pointer);
  pointers_.back().type = type.id;
}

void Translator::define(const Instruction& inst, const Opaque& opaque) {
  Record& r = fresh(inst);
  r.kind = RecordKind::kOpaque;
  r.values = {opaque.image.index, opaque.sampler.index};
  r.detail = static_cast<uint32_t>(opaques_.size());
  opaques_.push_back(opaque);
}

void Translator::bind(uint32_t to_id, const Instruction& inst, uint32_t word) {
  const uint32_t id = inst.word(word);
  if (m.type_of(to_id) != m.type_of(id)) inst.fail("%" + std::to_string(id) + " has the wrong type");
  Record copy;
  if (const Constant* c = m.constant(id)) {
    copy.kind = RecordKind::kValues;
    copy.values = constant_values(*c);
  } else {
    Record& from = record(inst, id);
    copy.kind = from.kind;
    copy.detail = from.detail;
    copy.values = usable(inst, from);
  }
  copy.region = b.region();
  value_scalars_ += static_cast<uint32_t>(copy.values.size());
  if (value_scalars_ > kMaxValueScalars) inst.fail("the shader has too many values");
  records_[m.definition[to_id] - 1] = std::move(copy);
}

void Translator::alias(const Instruction& inst, uint32_t word) { bind(inst.word(2), inst, word); }

// ---- arithmetic and effects -----------------------------------------------------------------------------------------------

ir::Value Translator::dot(std::span<const ir::Value> x, std::span<const ir::Value> y) {
  ir::Value sum = fmul(x[0], y[0]);
  for (size_t i = 1; i < x.size(); ++i) sum = fadd(sum, fmul(x[i], y[i]));
  return sum;
}

ir::Value Translator::lanes_with_effects() {
  if (!is_fragment()) return {};
  ir::Value lanes = stage.covered(b);
  if (!killed_.local) return lanes;
  const ir::Value alive = b.not_(b.get(killed_));
  return lanes ? b.and_(lanes, alive) : alive;
}

void Translator::effect(const std::function<void()>& body) {
  found_.writes_memory = true;
  if (const ir::Value lanes = lanes_with_effects())
    b.if_(lanes, body);
  else
    body();
}

ir::Value Translator::effect_value(ir::Type type, const std::function<ir::Value()>& body) {
  found_.writes_memory = true;
  const ir::Value lanes = lanes_with_effects();
  if (!lanes) return body();
  return b.if_else(
      lanes, {type}, [&] { return std::vector{body()}; }, [&] { return std::vector{b.zero(type)}; })[0];
}

void Translator::discard() { b.set(killed_, b.b1(true)); }

// ---- regions --------------------------------------------------------------------------------------------------------------

void Translator::in_if(const Instruction& inst, ir::Value cond, const std::function<void()>& then_body,
                       const std::function<void()>& else_body) {
  if (open_.size() > kMaxNesting) inst.fail("control flow is nested too deeply");
  const auto opened = [this](const std::function<void()>& body) {
    return [this, &body] {
      open_.push_back(b.region());
      body();
      open_.pop_back();
    };
  };
  b.if_else(cond, opened(then_body), opened(else_body));
}

void Translator::in_loop(const Instruction& inst, const std::function<ir::Value()>& body) {
  if (open_.size() > kMaxNesting) inst.fail("control flow is nested too deeply");
  b.loop({}, [&](std::span<const ir::Value>) {
    open_.push_back(b.region());
    const ir::Value again = body();
    open_.pop_back();
    return ir::Builder::LoopStep{again, {}};
  });
}

ir::Var Translator::variable(const Instruction& inst, ir::Type type) {
  if (++var_count_ > kMaxVars) inst.fail("the shader needs too many variables");
  return b.variable(type);
}

ir::Var& Translator::phi_var(const Instruction& phi, uint32_t scalar, ir::Type type) {
  std::vector<ir::Var>& vars = phis_[phi.word(2)];
  while (vars.size() <= scalar) vars.push_back({});
  if (!vars[scalar].local) vars[scalar] = variable(phi, type);
  return vars[scalar];
}

void Translator::instruction(const Instruction& inst) {
  const OpRow* row = find_op(inst.op());
  if (!row || !row->handler) inst.fail(why_unsupported(inst.op()));
  if (inst.size() < row->min_words) inst.fail("has too few operands");
  if (++instruction_count_ > kMaxInstructions || b.kernel().insts.size() > kMaxIrInstructions) {
    inst.fail("the shader is too large after inlining its functions");
  }
  contract_flags_ = inst.size() > 2 && m.decorations_of(inst.word(2)).no_contraction ? ir::kNoContract : 0;
  row->handler(*this, inst);
}

// ---- functions ------------------------------------------------------------------------------------------------------------

void Translator::call(const Instruction& inst) {
  const Function& callee = m.function(inst.word(3));
  if (inst.size() - 4 != callee.parameters.size()) inst.fail("has the wrong number of arguments");
  for (uint32_t i = 0; i < callee.parameters.size(); ++i) bind(callee.parameters[i], inst, 4 + i);
  returns_.push_back({});
  const Type& type = result_type(inst);
  if (type.id != callee.result_type) inst.fail("the result type is not the function's");
  if (type.kind != TypeKind::kVoid) {
    std::vector<ir::Var>& vars = return_vars_[callee.id];
    if (vars.empty()) {
      for (ir::Type t : m.flat_scalars(type.id)) vars.push_back(variable(inst, t));
    }
    returns_.back() = vars;
  }
  Flow(*this, callee).run();
  Values out;
  for (const ir::Var& var : returns_.back()) out.push_back(b.get(var));
  returns_.pop_back();
  if (type.kind != TypeKind::kVoid) define(inst, std::move(out));
}

void Translator::set_return(const Instruction& inst) {
  const Values v = values(inst, 1);
  const std::vector<ir::Var>& vars = returns_.back();
  if (v.size() != vars.size()) inst.fail("the value does not have the function's type");
  for (size_t i = 0; i < v.size(); ++i) {
    if (b.type(v[i]) != vars[i].type) inst.fail("the value does not have the function's type");
    b.set(vars[i], v[i]);
  }
}

// ---- the whole shader -----------------------------------------------------------------------------------------------------

Values Translator::constant_result(const Instruction& inst) {
  constant_result_.emplace();
  instruction(inst);
  return std::move(*constant_result_);
}

Translation Translator::run() {
  records_.resize(m.instructions.size());
  open_.push_back(b.region());
  prologue();
  returns_.push_back({});
  Flow(*this, m.function(m.entry_point)).run();
  epilogue();
  Translation t;
  if (killed_.local) t.discarded = b.get(killed_);
  return t;
}

Result<Translation> translate(const Module& module, ir::Builder& b, StageInterface& stage) {
  try {
    Translation translation;
    with_deep_stack([&] { translation = Translator(module, b, stage).run(); });
    return translation;
  } catch (Fault& fault) {
    return std::unexpected(std::move(fault.error));
  }
}

}  // namespace pineda::spirv
