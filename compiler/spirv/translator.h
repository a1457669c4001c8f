// Turns a Module's call tree into IR at a Builder's place. This class holds what instructions share: what each id stands for, the
// memory of variables, and checked access to operands. The instructions themselves are handlers (opcodes.h) in arith.cpp,
// memory.cpp, image.cpp ...; control flow is flow.h.
#pragma once

#include <functional>

#include "compiler/spirv/flat_memory.h"
#include "compiler/spirv/module.h"

namespace pineda::spirv {

using Values = std::vector<ir::Value>;  // one for each scalar, see module.h "Flattening"

// Bounds on the IR that one translation may make (functions are inlined, so a small module can ask for much).
inline constexpr uint32_t kMaxInstructions = 1u << 20;  // SPIR-V instructions, counted at each inlining
inline constexpr uint32_t kMaxIrInstructions = 1u << 22;
inline constexpr uint32_t kMaxVars = 1u << 18;          // scalar variables
inline constexpr uint32_t kMaxArrayBytes = 1u << 17;    // of a lane's dynamically indexed arrays
inline constexpr uint32_t kMaxValueScalars = 1u << 22;  // of all values
inline constexpr uint32_t kMaxNesting = 2200;  // Ifs and Loops: twice SPIR-V's limit of 1023 constructs (2.17), and some calls

// Where a pointer points. Flat memory (Function, Private, Input, Output) is counted in scalars, all other memory in bytes.
//
// A pointer that came through memory, a phi or a select knows no variable. It is either the three values kPointerScalars (a
// storage buffer or Workgroup memory) or an address (physical), and becomes `base` and `size_bytes` again when it is used.
struct Pointer {
  uint32_t variable = 0;  // id of the OpVariable, or 0: then base and size_bytes are set
  uint32_t type = 0;      // the pointer's own type id; 0 until it is defined
  uint32_t pointee = 0;   // type id
  spv::StorageClass storage = spv::StorageClassFunction;
  uint32_t offset = 0;                        // static part
  ir::Value index;                            // dynamic part of the offset, same unit; or unset
  uint32_t descriptor = 0;                    // element of an array of descriptors
  ir::Value descriptor_index;                 // or, when that is not constant, this
  ir::Value base, size_bytes;                 // Ptr and I32 when there is no variable
  ir::Value in_range;                         // B1: the dynamic part, in bytes, did not wrap at 2^32; unset: it cannot
  uint32_t index_alignment_bytes = 1u << 31;  // a power of two that divides the dynamic part
  uint32_t matrix_stride_bytes = 0;           // of the struct member that holds the matrix; 0 = none
  bool row_major = false;
  uint32_t component_stride_bytes = 0;  // of a vector that is a column of a row-major matrix; 0: its components are packed
};

// A loaded image, sampler, or both.
struct Opaque {
  uint32_t image_type = 0;  // type id; 0 for a sampler
  bool has_sampler = false;
  ImageRef image, sampler;
};

class Translator {
 public:
  Translator(const Module& module, ir::Builder& builder, StageInterface& stage) : m(module), b(builder), stage(stage) {}

  Translation run();
  // The values of one instruction whose operands are constants.
  Values constant_result(const Instruction& inst);

  const Module& m;
  ir::Builder& b;
  StageInterface& stage;

  // ---- operands: each takes the word that holds the id, and fails unless it is what is wanted ----
  Values values(const Instruction& inst, uint32_t word);
  Values floats(const Instruction& inst, uint32_t word);
  Values integers(const Instruction& inst, uint32_t word);
  Values bools(const Instruction& inst, uint32_t word);
  ir::Value scalar(const Instruction& inst, uint32_t word, ir::Type type);
  ir::Value index(const Instruction& inst, uint32_t word);  // an integer scalar of any width as I32
  Pointer pointer(const Instruction& inst, uint32_t word);
  Opaque opaque(const Instruction& inst, uint32_t word);
  const Type& type_of(const Instruction& inst, uint32_t word) const { return m.type(m.type_of(inst.word(word))); }
  const Type& result_type(const Instruction& inst) const { return m.type(inst.word(1)); }
  ir::Type component_of(const Type& type) const;  // of a scalar, vector or matrix; kVoid for other types

  // ---- results: bind word 2 ----
  ir::Value literal(ir::Type type, uint64_t bits);      // of a number's own format
  void define(const Instruction& inst, Values values);  // checks count and types against the result type
  void define(const Instruction& inst, const Pointer& pointer);
  void define(const Instruction& inst, const Opaque& opaque);
  void alias(const Instruction& inst, uint32_t word);                 // result = whatever operand `word` is
  void bind(uint32_t to_id, const Instruction& inst, uint32_t word);  // a parameter = an argument

  // ---- arithmetic that NoContraction reaches ----
  ir::Value fadd(ir::Value x, ir::Value y) { return b.op(ir::Op::kFAdd, b.type(x), {x, y}, 0, contract_flags_); }
  ir::Value fsub(ir::Value x, ir::Value y) { return b.op(ir::Op::kFSub, b.type(x), {x, y}, 0, contract_flags_); }
  ir::Value fmul(ir::Value x, ir::Value y) { return b.op(ir::Op::kFMul, b.type(x), {x, y}, 0, contract_flags_); }
  ir::Value dot(std::span<const ir::Value> x, std::span<const ir::Value> y);  // left to right

  // ---- memory (memory.cpp) ----
  Values load(const Instruction& inst, const Pointer& from);
  void store(const Instruction& inst, const Pointer& to, const Values& values);
  ir::Address address(const Instruction& inst, const Pointer& to, uint32_t extra_bytes = 0);  // of memory counted in bytes
  ir::Address atomic_address(const Instruction& inst, const Pointer& to);  // of an aligned scalar, whatever the pointer says
  BufferRef buffer(const Instruction& inst, const Pointer& p);             // of a descriptor or the push constants
  BufferRef memory_of(const Instruction& inst, const Pointer& p);          // of anything counted in bytes
  bool is_writable(const Pointer& p) const;                                // of a buffer: a storage buffer
  void declare_local(const Instruction& inst);                             // OpVariable in a function

  // ---- effects and lanes ----
  bool is_fragment() const { return m.stage == VK_SHADER_STAGE_FRAGMENT_BIT; }
  // Runs `body` for the lanes whose effects count: a fragment shader's helper and discarded invocations write nothing.
  void effect(const std::function<void()>& body);
  ir::Value effect_value(ir::Type type, const std::function<ir::Value()>& body);  // zero for the other lanes
  ir::Value lanes_with_effects();                                                 // B1; unset when every lane has
  void discard();
  ir::Var killed() const { return killed_; }  // local unset when the module has no discard
  ModuleInfo& found() { return found_; }

  // ---- regions: every If and Loop is opened through these, so that values know where they are usable ----
  void in_if(const Instruction& inst, ir::Value cond, const std::function<void()>& then_body,
             const std::function<void()>& else_body);
  void in_loop(const Instruction& inst, const std::function<ir::Value()>& body);  // body returns `again`
  size_t nesting() const { return open_.size(); }
  ir::Var variable(const Instruction& inst, ir::Type type);
  void instruction(const Instruction& inst);  // dispatches one instruction of a block
  void call(const Instruction& inst);         // OpFunctionCall: inlines
  ir::Var& phi_var(const Instruction& phi, uint32_t scalar, ir::Type type);
  void set_return(const Instruction& inst);  // OpReturnValue

 private:
  enum class RecordKind : uint8_t { kNone, kValues, kPointer, kOpaque };
  struct Record {
    RecordKind kind = RecordKind::kNone;
    ir::RegionId region = 0;
    uint32_t detail = 0;  // index in pointers_ or opaques_
    // kPointer: {index, descriptor_index, base, size_bytes, in_range}, kOpaque: those of image and sampler; each may be unset
    Values values;
    std::vector<ir::Var> escaped;  // filled when it is used where `region` is closed; parallel to values
    // A physical pointer that was looked up in `resolved_region`: base, size_bytes, offset. See pointer_from_values().
    Values resolved;
    ir::RegionId resolved_region = 0;
  };
  Record& record(const Instruction& inst, uint32_t id);
  Record& fresh(const Instruction& inst);
  Values usable(const Instruction& inst, Record& record);
  void escape(const Instruction& inst, Record& record);
  Values constant_values(const Constant& constant);
  Values pointer_values(const Instruction& inst, uint32_t word);        // of a Pointer: kPointerScalars
  Pointer pointer_from_values(const Instruction& inst, uint32_t word);  // the other way
  Values resolve_address(const Instruction& inst, ir::Value address);
  bool is_open(ir::RegionId region) const;
  Values typed(const Instruction& inst, uint32_t word, bool (*accept)(ir::Type), const char* what);
  void check_result(const Instruction& inst, const Values& values) const;

  void prologue();
  void epilogue();
  void module_variable(const Variable& v);
  void input_variable(const Instruction& inst, const Variable& v);
  ir::Value from_words(ir::Type type, ir::Value low, ir::Value high);
  void write_output(const InterfaceEntry& entry, ir::Value value);
  void allocate(const Instruction& inst, const Variable& v);
  void initialise(const Variable& v);
  const FlatMemory& flat(const Instruction& inst, const Pointer& p) const;
  Values load_flat(const Instruction& inst, const Pointer& from);
  void store_flat(const Instruction& inst, const Pointer& to, const Values& values);
  Values load_memory(const Instruction& inst, const Pointer& from);
  void store_memory(const Instruction& inst, const Pointer& to, const Values& values);
  uint8_t load_flags(const Pointer& from) const;
  uint64_t static_offset_bytes(const Pointer& p) const;

  std::vector<Record> records_;  // by index of the defining instruction
  std::optional<Values> constant_result_;
  std::vector<Pointer> pointers_;
  std::vector<Opaque> opaques_;
  std::unordered_map<uint32_t, FlatMemory> flat_;
  std::unordered_map<uint32_t, BufferRef> buffers_;                 // of bindings that are not arrays
  std::unordered_map<uint32_t, std::vector<ir::Var>> phis_;         // by phi id
  std::vector<ir::RegionId> open_;                                  // regions around the current place, outermost first
  std::vector<std::vector<ir::Var>> returns_;                       // of each function on the call stack
  std::unordered_map<uint32_t, std::vector<ir::Var>> return_vars_;  // by function id
  ir::Value shared_;
  ir::Var killed_;
  ModuleInfo found_;
  uint8_t contract_flags_ = 0;
  uint32_t instruction_count_ = 0, var_count_ = 0, array_bytes_ = 0, value_scalars_ = 0;
};

}  // namespace pineda::spirv
