// A parsed shader module, specialised and checked as far as its declarations go. Plain data: filled by parse(), never changed
// afterwards, so several threads may translate it at once.
//
// Flattening. Every value is the list of its scalars in depth-first order: a struct {vec2 a; float b[3];} is 5 scalars, a mat3x2
// (three columns of two rows) is 6, column by column. Type::scalar_count and Type::first_scalar describe this order; the
// translator, constants and interfaces all use it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "compiler/spirv/instruction.h"
#include "compiler/spirv/translate.h"

namespace pineda::spirv {

// Bounds on what an untrusted module may make us build.
inline constexpr uint32_t kMaxFlatScalars = 16384;         // of one variable, value or constant
inline constexpr uint32_t kMaxConstantScalars = 1u << 20;  // of all constants
inline constexpr uint32_t kMaxTypeDepth = 64;

enum class TypeKind : uint8_t {
  kVoid,
  kBool,
  kInt,
  kFloat,
  kVector,
  kMatrix,
  kArray,
  kRuntimeArray,
  kStruct,
  kPointer,
  kImage,
  kSampler,
  kSampledImage,
  kFunction
};

// What a pointer that is a value consists of: address of the memory, its size in bytes, offset in bytes.
inline constexpr std::array<ir::Type, 3> kPointerScalars{ir::Type::kI64, ir::Type::kI32, ir::Type::kI32};

struct ImageType {
  spv::Dim dim = spv::Dim2D;
  bool arrayed = false, multisampled = false;
  bool storage = false;  // Sampled operand: 2 = storage, 1 = with a sampler
  spv::ImageFormat format = spv::ImageFormatUnknown;
};

struct Type {
  TypeKind kind = TypeKind::kVoid;
  bool is_signed = false;                                 // kInt
  bool is_value = false;                                  // can be flattened into scalars
  ir::Type scalar = ir::Type::kVoid;                      // kBool, kInt, kFloat
  spv::StorageClass storage = spv::StorageClassFunction;  // kPointer
  uint32_t id = 0;
  uint32_t element = 0;           // vector: component; matrix: column; arrays: element; pointer: pointee; image: texel component;
                                  // sampled image: image; function: result
  uint32_t count = 0;             // vector, matrix, array
  uint32_t depth = 0;             // of nesting
  uint64_t scalar_count = 0;      // may be far beyond kMaxFlatScalars for arrays in buffers
  std::vector<uint32_t> members;  // struct members, function parameters
  std::vector<uint64_t> first_scalar;  // of each struct member
  // The layout that we choose where the shader declares none (Workgroup memory): every scalar at its natural alignment.
  uint64_t natural_bytes = 0;
  uint32_t natural_alignment_bytes = 1;
  std::vector<uint64_t> natural_offset_bytes;  // of each struct member
  ImageType image;

  bool is_scalar() const { return scalar != ir::Type::kVoid; }
};

struct Decorations {
  std::optional<uint32_t> location, component, index, built_in, set, binding, spec_id, array_stride, matrix_stride, offset;
  std::optional<spv::FPRoundingMode> rounding_mode;
  bool flat = false, no_perspective = false, centroid = false, sample = false;
  bool row_major = false, buffer_block = false, non_writable = false, no_contraction = false;
};

// Bits of each scalar, zero-extended (a float's own pattern, a bool as 0 or 1); empty = all zero.
struct Constant {
  uint32_t type = 0;
  bool is_spec = false;
  std::vector<uint64_t> scalars;
};

struct Variable {
  uint32_t id = 0, pointee = 0;
  spv::StorageClass storage = spv::StorageClassFunction;
  uint32_t initializer = 0;  // constant id, or 0
  uint32_t offset_words = 0;
  // by usage.cpp
  bool used = false;          // by the entry point's call tree
  uint32_t dynamic_step = 0;  // dynamic indices move by multiples of this many scalars; 0 = all indices are constant
  bool written = false;
  std::vector<bool> written_scalars;  // Output variables
};

enum class MergeKind : uint8_t { kNone, kSelection, kLoop };

struct Block {
  uint32_t label = 0;
  uint32_t first = 0, terminator = 0;  // indices in Module::instructions; first is behind the OpLabel
  MergeKind merge_kind = MergeKind::kNone;
  uint32_t merge = 0, continue_target = 0;
  uint32_t predecessors = 0;  // edges into this block
};

struct Function {
  uint32_t id = 0, result_type = 0;
  uint32_t first = 0;                                  // index of the OpFunction
  std::vector<uint32_t> parameters;                    // ids
  std::vector<Block> blocks;                           // blocks[0] is the entry
  std::unordered_map<uint32_t, uint32_t> block_index;  // label -> index in blocks
  bool returns_early = false;                          // may return from inside a construct
  // by usage.cpp: what the body does through pointers
  std::vector<uint32_t> parameter_steps;  // as Variable::dynamic_step
  std::vector<bool> written_parameters;
};

// One scalar of an Input or Output variable. Stages exchange 32-bit words: a 16-bit number travels widened, a 64-bit one as two.
struct InterfaceEntry {
  std::optional<InterfaceScalar> scalar;
  std::optional<InterfaceScalar> high;  // the upper word of a 64-bit number
  bool is_signed = false;
  bool is_zero = false;           // an input that is always zero; scalar is unset
  uint32_t unknown_built_in = 0;  // when scalar is unset
};

class Module {
 public:
  std::vector<uint32_t> words;
  std::vector<Instruction> instructions;  // views of words
  VkShaderStageFlagBits stage = VK_SHADER_STAGE_COMPUTE_BIT;
  uint32_t bound = 0;
  bool variable_pointers = false;    // pointers to storage buffers and Workgroup memory are values
  std::vector<uint32_t> definition;  // id -> 1 + index of the instruction that defines it; 0 = none
  std::unordered_map<uint32_t, Type> types;
  std::unordered_map<uint32_t, Constant> constants;
  std::unordered_map<uint32_t, Variable> variables;              // module scope and function scope
  std::vector<uint32_t> module_variables;                        // in order of declaration
  std::unordered_map<uint32_t, Decorations> decorations;         // of ids
  std::unordered_map<uint64_t, Decorations> member_decorations;  // key: member_key()
  std::unordered_map<uint32_t, Function> functions;
  std::vector<uint32_t> call_order;       // functions that the entry point reaches, callees first
  uint32_t glsl_std_450 = 0;              // id of the import, 0 = none
  std::vector<uint32_t> ignored_imports;  // NonSemantic.*
  uint32_t entry_point = 0;               // function id
  std::vector<uint32_t> entry_interface;
  uint32_t constant_scalars = 0;                                                // used of kMaxConstantScalars
  std::unordered_map<uint32_t, std::vector<InterfaceEntry>> interface_entries;  // Input and Output variables in use
  std::unordered_map<uint32_t, uint32_t> shared_offset_bytes;                   // Workgroup variables
  ModuleInfo info;

  const Type& type(uint32_t id) const;                   // fails unless id is a type
  const Constant* constant(uint32_t id) const;           // null unless id is a constant
  uint32_t type_of(uint32_t id) const;                   // type id of a result; fails when it has none
  const Decorations& decorations_of(uint32_t id) const;  // empty ones when undecorated
  const Decorations& member_of(uint32_t struct_type, uint32_t member) const;
  const Variable* variable(uint32_t id) const;  // null unless id is a variable
  const Function& function(uint32_t id) const;
  std::vector<ir::Type> flat_scalars(uint32_t type_id) const;         // fails unless is_value and at most kMaxFlatScalars
  uint32_t constant_u32(const Instruction& user, uint32_t id) const;  // of an integer scalar constant
  bool is_ignored_import(uint32_t id) const;

  static uint64_t member_key(uint32_t struct_type, uint32_t member) { return static_cast<uint64_t>(struct_type) << 32 | member; }
};

// The literals of an OpSwitch, as wide as its selector, and where they lead; without the default.
struct SwitchCase {
  uint64_t literal;
  uint32_t label;
};
std::vector<SwitchCase> switch_cases(const Module& m, const Instruction& inst);  // functions.cpp

// The parts of parse(), in the order in which it calls them.
void check_support(Module& m, const Instruction& inst);  // support.cpp: capabilities, memory model
void check_execution_mode(const Instruction& inst);      // support.cpp
void decorate(Module& m, const Instruction& inst);       // decorations.cpp
void declare_type(Module& m, const Instruction& inst);   // types.cpp
void declare_constant(Module& m, const Instruction& inst,
                      std::span<const SpecializationConstant> specialization);  // constants.cpp
Constant fold_spec_op(const Module& m, const Instruction& inst);                // spec_op.cpp
void declare_variable(Module& m, const Instruction& inst);                      // types.cpp
void read_functions(Module& m);                                                 // functions.cpp
void find_usage(Module& m);                                                     // usage.cpp
void flatten_interfaces(Module& m);                                             // interface.cpp
void reflect(Module& m);  // reflect.cpp: a trial translation fills ModuleInfo

}  // namespace pineda::spirv
