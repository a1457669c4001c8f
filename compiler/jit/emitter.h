// Translates one ir::Kernel into one LLVM function. Internal to libpineda_jit.so.
//
// Representation of a value. Rates Draw, Prim and Wave: an LLVM scalar. Rate Lane: a vector of 16 elements, which LLVM splits
// into 2 x 8 or 4 x 4 where registers are narrower. Elements: iN for integers, i64 for Ptr, float, double, and i16 for F16
// (arithmetic on it goes through float, so that no ISA depends on LLVM's `half`, which calls library functions where F16C is
// missing).
//
// Booleans. A uniform B1 is an i1. A B1 per lane is a *mask*: <16 x i1> on AVX-512, which has registers for it; elsewhere <16 x
// i32> of 0 and -1, because LLVM would pack <16 x i1> to bytes at each block border and unpack it for each blend. to_i1() and
// from_i1() convert; in one block they cancel out.
//
// Poison. No instruction that is emitted may give poison for any input (inactive lanes hold garbage), so: no nsw/nuw/inbounds,
// shift counts and divisors are made valid first, conversions saturate, and values of branches that are not taken are zero
// instead of undef.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/ir/wave_frame.h"
#include "compiler/jit/jit.h"
#include "compiler/jit/llvm_ir.h"

namespace pineda::jit {

// What the emitted code may rely on beyond the instruction set that LLVM knows of.
struct Features {
  bool mask_registers;  // AVX-512
  bool fma, half;       // FMA3, F16C
  bool gathers;         // AVX2: vpgatherdd ...
  bool masked_moves;    // AVX: vmaskmovps (32- and 64-bit elements)
  bool scatters;        // AVX-512
  uint32_t vector_bits;
};
Features features_of(Isa isa);

// Offsets below this can be indices of a gather, which sign-extends them, with a few bytes of room.
inline constexpr uint64_t kSmallOffset = (uint64_t{1} << 31) - 8;

inline constexpr const char* kFmaSymbol = "pineda.fma_f64";  // double(double, double, double)

class Emitter {
 public:
  Emitter(llvm::Module& module, const ir::Kernel& kernel, Isa isa);

  // The function, or null with *error set.
  llvm::Function* run(std::string* error);

  // What the pass list depends on.
  bool has_locals() const { return !local_slot_.empty(); }

 private:
  using V = llvm::Value*;

  // Active lanes of the region being emitted; null lanes = all 16, known now. Wherever code with effects is emitted, at least one
  // lane is active when it runs: regions that could be entered without are branched around.
  struct Exec {
    V lanes = nullptr;  // mask
    bool full() const { return lanes == nullptr; }
  };

  // One Load, Store or Atomic. `base` is i64, `offset` and `limit` are i32; each is a vector when it varies.
  struct Access {
    V base = nullptr, offset = nullptr, limit = nullptr;
    V where = nullptr;  // mask: lanes that may be accessed, beside what the limit tells; null: all
    uint32_t lane_stride_bytes = 0, size_bytes = 0;
    llvm::Type* element = nullptr;
    bool invariant = false;
    bool base_readable = false;          // reading an element at `base` itself never faults
    bool small_offset = false;           // known to be below 2^31 - 8
    uint64_t offset_bound = 0xffffffff;  // the largest offset of an active lane
    bool uniform() const;                // one address for all lanes
    bool contiguous() const;             // consecutive lanes are consecutive elements
  };

  // Sixteen addresses: base + zero-extended offset, or given in full.
  struct LaneAddresses {
    V base = nullptr;     // i64
    V offset = nullptr;   // <16 x i32>
    V address = nullptr;  // <16 x i64>; then the others are null
    bool small = false;   // offset is known to be below 2^31 - 8
  };
  struct LaneSlots {  // the same on the stack, to be indexed by a variable lane number
    V base = nullptr, offsets = nullptr, addresses = nullptr;
  };

  struct LocalElement {
    ir::Type type;
    llvm::Type* row;  // 16 elements
    V in_range;       // null: known; i1, or a mask when `varying` is used
    V address;        // of the row; null: out of range
    Access varying;   // used when its base is set: each lane has its own row
  };

  // ---- emit.cpp: frame and dispatch
  void emit_frame();
  void emit_stop_pointer();
  void emit_prim_loop();
  void emit_wave_loop(V prim_record);
  void emit_wave(llvm::BasicBlock* skip);
  void emit_insts(ir::RegionId region);
  void split_long_block();
  V emit(const ir::Inst& inst, ir::Value id);
  V emit_source(const ir::Inst& inst);
  V emit_constant(const ir::Inst& inst);
  V emit_ptr_add(const ir::Inst& inst);
  void emit_call(const ir::Inst& inst);
  V load_field(V record, uint64_t offset_bytes, llvm::Type* type);
  V fail(const std::string& text, llvm::Type* type);

  // ---- values
  bool is_lane(ir::Value v) const { return kernel_.at(v).rate == ir::Rate::kLane; }
  llvm::Type* element_type(ir::Type t) const;
  llvm::Type* lane_type(llvm::Type* element) const { return llvm::FixedVectorType::get(element, kLanes); }
  llvm::Type* value_type(ir::Type t, bool lane) const;
  V scalar(ir::Value v);  // fails when it varies
  V vector(ir::Value v);  // broadcasts when it is uniform
  V get(ir::Value v, bool lane) { return lane ? vector(v) : scalar(v); }
  V arg(const ir::Inst& inst, uint32_t i) { return get(inst.operand[i], inst.rate == ir::Rate::kLane); }
  V broadcast_value(V scalar);  // at the insertion point; i1 becomes a mask
  V shape(V value, bool lane) { return lane && !is_vector(value) ? broadcast_value(value) : value; }
  static V int_const(llvm::Type* like, uint64_t bits);  // scalar or splat
  static V float_const(llvm::Type* like, double value);
  llvm::Type* with_element(llvm::Type* like, llvm::Type* element) const;
  static bool is_vector(V v) { return v->getType()->isVectorTy(); }

  // ---- emit_mask.cpp
  V to_i1(V b1);      // mask -> <16 x i1>; i1 -> i1
  V from_i1(V bits);  // <16 x i1> -> mask; i1 -> i1
  V mask_not(V mask);
  V exec_and(V mask);   // active lanes of `mask`
  V any(V mask);        // i1
  V mask_bits(V mask);  // i16
  V exec_bits();        // i32
  V mask_from_bits(V bits16);
  V select(V cond_b1, V a, V b);
  V full_mask();
  V emit_unpack_mask(const ir::Inst& inst);
  V emit_ballot(const ir::Inst& inst);
  V emit_quad_swizzle(const ir::Inst& inst);

  // ---- emit_subgroup.cpp
  V emit_shuffle(const ir::Inst& inst);
  V emit_reduce(const ir::Inst& inst);
  V combine(ir::ReduceOp op, ir::Type type, V a, V b);
  V permute(V x, const std::vector<int>& from);
  V permute(V x, V index);
  V permute_words(V x, V index);
  V only_active(V x, ir::Type type, uint64_t identity_imm);

  // ---- emit_int.cpp
  V emit_int(const ir::Inst& inst);
  V emit_bit_count(const ir::Inst& inst, V a);
  V emit_madd16(V a, V b);
  V emit_mul_high(V a, V b, bool is_signed);
  V emit_divide(const ir::Inst& inst);
  V quotient(V a, V b, bool is_signed, bool constant_divisor);
  V quotient_by_f64(V a, V b, bool is_signed);
  V emit_shift(const ir::Inst& inst);
  V emit_int_compare(const ir::Inst& inst);
  V emit_int_convert(const ir::Inst& inst);
  V low_words(const ir::Inst& inst, V a);

  // ---- emit_float.cpp
  V emit_float(const ir::Inst& inst);
  V emit_float_compare(const ir::Inst& inst);
  V emit_float_sign(const ir::Inst& inst);
  V emit_min_max(const ir::Inst& inst);
  V emit_fma(const ir::Inst& inst);
  V fma_to_odd_f64(V a, V b, V c);
  V fma_f64_by_call(V a, V b, V c);
  V fma_f32_by_call(V a, V b, V c);
  llvm::Function* create_fma_function(uint32_t lanes);
  V emit_canon(const ir::Inst& inst);

  // ---- emit_convert.cpp
  V emit_convert(const ir::Inst& inst);
  V float_to_int(V x, ir::Type from, ir::Type to, bool is_signed);
  V f32_to_i32(V x);
  V f32_to_u32(V x);
  V truncate_f32(V x);  // cvttps2dq: 0x80000000 when out of range
  V truncate_f32_unsigned_512(V x);
  V int_to_float(V x, ir::Type to, bool is_signed);
  V convert_float(V x, ir::Type from, ir::Type to);
  V half_to_f32(V h);
  V f32_to_half(V x);
  V f64_to_odd_f32(V x);
  V round_to_odd(V rounded, V error, llvm::Type* bits_type);
  V widen(V x, ir::Type type);  // F16 -> f32; else unchanged
  V narrow(V x, ir::Type type);
  std::vector<V> split(V x, uint32_t lanes);
  V join(std::vector<V> parts);

  // ---- emit_memory.cpp
  Access access_of(const ir::Inst& inst, llvm::Type* element);
  V emit_load(const ir::Inst& inst);
  V emit_plain_load(const ir::Inst& inst);
  void forget_memory();
  void emit_store(const ir::Inst& inst);
  V uniform_load(const Access& a);
  V contiguous_load(const Access& a, V mask);
  V contiguous_load_by_lane(const Access& a, V mask);
  void contiguous_store(const Access& a, V value, V mask);
  void uniform_store(const Access& a, V value);
  V load_at(llvm::Type* type, V address_i64, bool invariant);
  void store_at(V value, V address_i64);
  V first_address(const Access& a);  // i64, of lane 0
  V zeros_address();                 // i64, of 16 zero bytes
  void mark_invariant(llvm::Instruction* load, bool invariant);

  // ---- emit_bounds.cpp
  uint64_t upper_bound(ir::Value v, bool with_facts, uint32_t depth = 0) const;
  uint64_t expression_bound(ir::Value v, bool with_facts, uint32_t depth) const;
  uint64_t carried_bound(ir::Value arg, uint32_t depth) const;
  uint64_t compared_bound(const ir::Inst& compare, uint64_t x_bound, bool with_facts) const;
  void for_each_implied(ir::Value condition, const std::function<void(const ir::Inst&)>& fn, uint32_t depth) const;
  void learn(ir::Value condition);
  bool is_known_in_bounds(const Access& a) const;
  bool is_known_true(ir::Value condition, bool with_facts) const;
  void set_limit(Access& a, ir::Value limit, bool with_facts);
  V both(V a, V b);
  V uniform_in_bounds(const Access& a);  // i1; null when unchecked
  V lanes_in_bounds(const Access& a);    // mask; null when unchecked

  // ---- emit_gather.cpp
  LaneAddresses lane_addresses(const Access& a);
  V lane_pointers(const LaneAddresses& at);  // <16 x ptr>
  V gather(const Access& a, V mask);
  V gather_native(llvm::Type* element, const LaneAddresses& at, V mask, bool invariant);
  V gather_narrow(const Access& a, const LaneAddresses& at, V mask);
  V gather_scalar(const Access& a, const LaneAddresses& at);
  V gather_scalar_masked(const Access& a, const LaneAddresses& at, V mask);
  void scatter(const Access& a, V value, V mask);
  LaneSlots spill_addresses(const LaneAddresses& at);
  V slot_address(const LaneSlots& slots, V lane_i64);
  void for_each_lane(V bits_i32, const std::function<void(V lane_i64)>& body);
  V stack_slot(llvm::Type* type, const char* role);
  V spill(V vector, const char* role);  // ptr to its elements
  V slot_load(V slot, llvm::Type* element, V lane_i64);
  void slot_store(V slot, V value, V lane_i64);

  // ---- emit_atomic.cpp
  V emit_atomic(const ir::Inst& inst);
  V atomic_fadd(V at, V value);
  V modified(ir::AtomicOp op, V old, V value, V expected);
  V add_float_bits(V a, V b);

  // ---- emit_local.cpp
  void create_locals();
  void clear_local(ir::Value local);
  LocalElement local_element_at(const ir::Inst& inst);
  V emit_local_load(const ir::Inst& inst);
  void emit_local_store(const ir::Inst& inst);
  V first_active_lane(V row, ir::Type t);
  llvm::Type* local_element(ir::Type t) const;
  V to_local(V value, ir::Type t);
  V from_local(V value, ir::Type t);

  // ---- emit_group.cpp: kernels with barriers
  struct GroupTail;
  void emit_group(V prim_record);
  void emit_group_region(ir::RegionId region, std::optional<uint32_t> mask_offset, const GroupTail* tail);
  void emit_phase(const std::vector<ir::Value>& insts, std::optional<uint32_t> mask_offset, const GroupTail* tail);
  void emit_in_phase(ir::Value v, const GroupTail* tail);
  void load_kept(const std::vector<ir::Value>& insts);
  V load_from_frame(ir::Value v);
  void store_to_frame(ir::Value v, V value, V where);
  V frame_address(uint32_t offset_bytes);
  void enter_construct(ir::Value v);
  void leave_side(const GroupTail& tail);
  void leave_turn(const GroupTail& tail);
  void emit_group_if(ir::Value v, std::optional<uint32_t> mask_offset);
  void emit_group_loop(ir::Value v, std::optional<uint32_t> mask_offset);
  void store_mask(uint32_t offset_bytes, V bits16);
  void add_to_flag(V flag, V bits16);
  bool is_kept(ir::Value v) const { return frame_.offset[v.id] != ir::WaveFrame::kNone; }
  bool has_barriers() const { return frame_.bytes != 0; }

  // ---- emit_control.cpp
  void emit_if(const ir::Inst& inst, ir::Value id);
  void emit_first_side(const ir::Inst& inst, ir::Value id);
  void emit_uniform_if(const ir::Inst& inst, ir::Value id);
  void emit_divergent_if(const ir::Inst& inst, ir::Value id);
  void emit_flat_if(const ir::Inst& inst, ir::Value id);
  std::vector<V> emit_guarded_side(ir::RegionId region, V mask, const std::vector<ir::Value>& results);
  std::vector<V> yielded_values(ir::RegionId region, const std::vector<ir::Value>& results, bool as_lanes);
  void merge_sides(V cond, const std::vector<ir::Value>& results, const std::vector<V>& then_values,
                   const std::vector<V>& else_values);
  bool is_flat(ir::RegionId region, uint32_t* cost) const;
  bool is_trivial(ir::RegionId region) const;  // Yield only
  struct Carried;
  void emit_loop(const ir::Inst& inst, ir::Value id);
  std::vector<Carried> loop_carried(const ir::Inst& inst, ir::Value id);
  void start_carried(Carried& c, V first, llvm::BasicBlock* before, bool divergent);
  V next_carried(const Carried& c, V mask);
  std::vector<ir::Value> results_of(ir::Value id) const;

  llvm::BasicBlock* block(const char* name);
  void start(llvm::BasicBlock* b) { b_.SetInsertPoint(b); }

  llvm::Module& module_;
  llvm::LLVMContext& context_;
  const ir::Kernel& kernel_;
  const Features features_;
  llvm::IRBuilder<> b_;  // folds constants only: phis are incomplete while a loop is emitted, so nothing may look through them
  llvm::Function* function_ = nullptr;
  llvm::BasicBlock* entry_ = nullptr;  // allocas only; branches to the draw region's code
  std::string error_;

  std::vector<V> value_;                                          // by instruction
  std::vector<V> splat_;                                          // its broadcast, when one was needed
  std::unordered_map<uint32_t, std::vector<ir::Value>> results_;  // If or Loop -> its Results
  std::unordered_map<uint32_t, V> local_slot_;                    // ptr: on the stack, or in the wave's frame
  std::map<std::pair<llvm::Type*, std::string>, V> slots_;
  uint32_t insts_since_split_ = 0;
  Exec exec_;
  std::vector<std::pair<ir::Value, uint64_t>> facts_;    // value, what it is at most in active lanes here
  std::unordered_map<uint32_t, ir::Value> loop_of_arg_;  // LoopArgs of the Loops around
  const std::vector<bool> with_barriers_;                // by region
  const ir::WaveFrame frame_;
  V group_frames_ = nullptr, group_waves_ = nullptr, group_count_ = nullptr;  // i64: of the workgroup at hand
  V frame_ptr_ = nullptr;                                                     // i64: of the wave at hand
  std::unordered_map<uint32_t, V> any_lane_;  // If or Loop that varies: ptr to i16[2], whether a lane wants a side or a turn
  V draw_ptr_ = nullptr, thread_ptr_ = nullptr, prim_ptr_ = nullptr, wave_ptr_ = nullptr;  // i64
  V stop_ptr_ = nullptr;  // of the word that ends loops; null: the kernel has none
  llvm::Function* fma_function_ = nullptr;
  llvm::GlobalVariable* zeros_ = nullptr;
  llvm::GlobalVariable* one_wave_ = nullptr;
};

}  // namespace pineda::jit
