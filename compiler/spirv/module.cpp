#include "compiler/spirv/module.h"

#include <algorithm>
#include <cstring>

#include "base/deep_stack.h"

namespace pineda::spirv {

const Type& Module::type(uint32_t id) const {
  const auto found = types.find(id);
  if (found == types.end()) fail("%" + std::to_string(id) + " is not a type.");
  return found->second;
}

const Constant* Module::constant(uint32_t id) const {
  const auto found = constants.find(id);
  return found == constants.end() ? nullptr : &found->second;
}

uint32_t Module::type_of(uint32_t id) const {
  const uint32_t index = id < definition.size() ? definition[id] : 0;
  if (index == 0) fail("%" + std::to_string(id) + " is not defined.");
  const Instruction& inst = instructions[index - 1];
  bool has_result = false, has_type = false;
  spv::HasResultAndType(inst.op(), &has_result, &has_type);
  if (!has_type) inst.fail("%" + std::to_string(id) + " has no type");
  return type(inst.word(1)).id;
}

const Decorations& Module::decorations_of(uint32_t id) const {
  static const Decorations kNone;
  const auto found = decorations.find(id);
  return found == decorations.end() ? kNone : found->second;
}

const Decorations& Module::member_of(uint32_t struct_type, uint32_t member) const {
  static const Decorations kNone;
  const auto found = member_decorations.find(member_key(struct_type, member));
  return found == member_decorations.end() ? kNone : found->second;
}

const Variable* Module::variable(uint32_t id) const {
  const auto found = variables.find(id);
  return found == variables.end() ? nullptr : &found->second;
}

const Function& Module::function(uint32_t id) const {
  const auto found = functions.find(id);
  if (found == functions.end()) fail("%" + std::to_string(id) + " is not a function.");
  return found->second;
}

bool Module::is_ignored_import(uint32_t id) const { return std::ranges::find(ignored_imports, id) != ignored_imports.end(); }

uint32_t Module::constant_u32(const Instruction& user, uint32_t id) const {
  const Constant* c = constant(id);
  if (!c || type(c->type).kind != TypeKind::kInt) user.fail("%" + std::to_string(id) + " is not an integer constant");
  return c->scalars.empty() ? 0 : static_cast<uint32_t>(std::min<uint64_t>(c->scalars[0], ~0u));
}

std::vector<ir::Type> Module::flat_scalars(uint32_t type_id) const {
  const Type& t = type(type_id);
  if (!t.is_value) fail("Type %" + std::to_string(type_id) + " cannot be a value.");
  if (t.scalar_count > kMaxFlatScalars) fail("Type %" + std::to_string(type_id) + " has more than 16384 scalars.");
  if (t.is_scalar()) return {t.scalar};
  if (t.kind == TypeKind::kPointer) return {kPointerScalars.begin(), kPointerScalars.end()};
  std::vector<ir::Type> out;
  if (t.kind == TypeKind::kStruct) {
    for (uint32_t member : t.members) {
      const std::vector<ir::Type> part = flat_scalars(member);
      out.insert(out.end(), part.begin(), part.end());
    }
  } else {
    const std::vector<ir::Type> part = flat_scalars(t.element);
    for (uint32_t i = 0; i < t.count && !part.empty(); ++i) out.insert(out.end(), part.begin(), part.end());
  }
  return out;
}

namespace {

class Parser {
 public:
  Parser(const ShaderSource& source, Module& m) : source_(source), m_(m) {}

  void run() {
    m_.words.assign(source_.words.begin(), source_.words.end());
    m_.stage = source_.stage;
    m_.instructions = split_instructions(m_.words, &m_.bound);
    number_results();
    for (const Instruction& inst : m_.instructions) annotation(inst);
    declarations();
    read_functions(m_);
    if (m_.entry_point == 0) fail("The module has no entry point \"" + source_.entry_point + "\" for this stage.");
    execution_modes();
    find_usage(m_);
    flatten_interfaces(m_);
    reflect(m_);
  }

 private:
  void number_results() {
    m_.definition.assign(m_.bound, 0);
    for (uint32_t i = 0; i < m_.instructions.size(); ++i) {
      const Instruction& inst = m_.instructions[i];
      bool has_result = false, has_type = false;
      spv::HasResultAndType(inst.op(), &has_result, &has_type);
      if (!has_result) continue;
      const uint32_t id = inst.word(has_type ? 2 : 1);
      if (id == 0 || id >= m_.bound) inst.fail("result %" + std::to_string(id) + " is not below the id bound");
      if (m_.definition[id] != 0) inst.fail("result %" + std::to_string(id) + " is defined twice");
      m_.definition[id] = i + 1;
    }
  }

  void annotation(const Instruction& inst) {
    switch (inst.op()) {
      case spv::OpCapability:
      case spv::OpMemoryModel:
        check_support(m_, inst);
        break;
      case spv::OpExtInstImport:
        import(inst);
        break;
      case spv::OpEntryPoint:
        entry_point(inst);
        break;
      case spv::OpDecorate:
      case spv::OpDecorateId:
      case spv::OpMemberDecorate:
      case spv::OpGroupDecorate:
      case spv::OpGroupMemberDecorate:
        decorate(m_, inst);
        break;
      default:
        break;
    }
  }

  void import(const Instruction& inst) {
    const std::string name = inst.string(2);
    if (name == "GLSL.std.450")
      m_.glsl_std_450 = inst.word(1);
    else if (name.starts_with("NonSemantic.") || name == "OpenCL.DebugInfo.100")
      m_.ignored_imports.push_back(inst.word(1));
    else
      inst.fail("extended instruction set \"" + name + "\" is not supported");
  }

  static std::optional<VkShaderStageFlagBits> stage_of(uint32_t model) {
    switch (model) {
      case spv::ExecutionModelVertex:
        return VK_SHADER_STAGE_VERTEX_BIT;
      case spv::ExecutionModelFragment:
        return VK_SHADER_STAGE_FRAGMENT_BIT;
      case spv::ExecutionModelGLCompute:
        return VK_SHADER_STAGE_COMPUTE_BIT;
      default:
        return std::nullopt;
    }
  }

  void entry_point(const Instruction& inst) {
    uint32_t next = 0;
    const std::string name = inst.string(3, &next);
    if (name != source_.entry_point || stage_of(inst.word(1)) != source_.stage || m_.entry_point != 0) return;
    m_.entry_point = inst.word(2);
    const auto interface = inst.from(next);
    m_.entry_interface.assign(interface.begin(), interface.end());
  }

  // Types, constants and variables of module scope, in order; function bodies are skipped.
  void declarations() {
    bool in_function = false;
    for (const Instruction& inst : m_.instructions) {
      const spv::Op op = inst.op();
      if (op == spv::OpFunction) in_function = true;
      if (op == spv::OpFunctionEnd) in_function = false;
      if (in_function) continue;
      if ((op >= spv::OpTypeVoid && op <= spv::OpTypeFunction) || op == spv::OpTypeForwardPointer) {
        declare_type(m_, inst);
      } else if ((op >= spv::OpConstantTrue && op <= spv::OpSpecConstantOp) || op == spv::OpUndef) {
        declare_constant(m_, inst, source_.specialization);
      } else if (op == spv::OpVariable) {
        if (inst.word(3) == spv::StorageClassFunction) inst.fail("a Function variable stands outside a function");
        declare_variable(m_, inst);
        m_.module_variables.push_back(inst.word(2));
      }
    }
  }

  void execution_modes() {
    for (const Instruction& inst : m_.instructions) {
      const bool is_mode = inst.op() == spv::OpExecutionMode || inst.op() == spv::OpExecutionModeId;
      if (!is_mode || inst.word(1) != m_.entry_point) continue;
      check_execution_mode(inst);
      const auto mode = inst.word_as<spv::ExecutionMode>(2);
      if (mode == spv::ExecutionModeEarlyFragmentTests) m_.info.early_fragment_tests = true;
      if (mode == spv::ExecutionModeDepthGreater) m_.info.depth_mode = DepthMode::kGreater;
      if (mode == spv::ExecutionModeDepthLess) m_.info.depth_mode = DepthMode::kLess;
      if (mode == spv::ExecutionModeDepthUnchanged) m_.info.depth_mode = DepthMode::kUnchanged;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        if (mode == spv::ExecutionModeLocalSize) m_.info.local_size[axis] = inst.word(3 + axis);
        if (mode == spv::ExecutionModeLocalSizeId) m_.info.local_size[axis] = m_.constant_u32(inst, inst.word(3 + axis));
      }
    }
    workgroup_size_constant();
    uint64_t invocations = 1;
    for (uint32_t size : m_.info.local_size) invocations *= std::min(size, 1u << 16);
    if (invocations == 0 || invocations > 1u << 16) fail("The workgroup size is out of range.");
  }

  // A constant decorated with WorkgroupSize takes precedence over the execution mode (Vulkan, "WorkgroupSize").
  void workgroup_size_constant() {
    for (const auto& [id, d] : m_.decorations) {
      if (d.built_in != static_cast<uint32_t>(spv::BuiltInWorkgroupSize)) continue;
      const Constant* c = m_.constant(id);
      if (!c || c->scalars.size() != 3) fail("The WorkgroupSize built-in is not a constant of three integers.");
      for (uint32_t axis = 0; axis < 3; ++axis) m_.info.local_size[axis] = static_cast<uint32_t>(c->scalars[axis]);
    }
  }

  const ShaderSource& source_;
  Module& m_;
};

}  // namespace

Result<ModulePtr> parse(const ShaderSource& source) {
  ModulePtr module(new Module);
  try {
    with_deep_stack([&] { Parser(source, *module).run(); });
  } catch (Fault& fault) {
    return std::unexpected(std::move(fault.error));
  }
  return module;
}

const ModuleInfo& info(const Module& module) { return module.info; }

void ModuleDeleter::operator()(Module* module) const { delete module; }

}  // namespace pineda::spirv
