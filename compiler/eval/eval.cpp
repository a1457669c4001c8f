#include "compiler/eval/eval.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "base/float_environment.h"
#include "base/stop_word.h"
#include "compiler/eval/code.h"
#include "compiler/eval/memory.h"

namespace pineda::eval {
namespace {

using ir::Op;
using Mask = uint32_t;
constexpr Mask kAllActive = (1u << kLanes) - 1;

template <class Memory>
class Machine {
 public:
  Machine(const Code& code, Memory& memory) : code_(code), memory_(memory), values_(new uint64_t[code.value_count]()) {
    for (const Constant& constant : code.constants) fill(constant.slot, constant.raw);
  }

  void run(const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count, const void* waves) {
    draw_ = draw;
    thread_ = thread;
    block(code_.draw, kAllActive);
    for (uint32_t p = 0; p < prim_count; ++p) {
      prim_ = prims[p].prim;
      block(code_.prim, kAllActive);
      const uint8_t* first = static_cast<const uint8_t*>(waves) + uint64_t{prims[p].first_wave} * code_.wave_stride_bytes;
      if (code_.has_barriers) {
        run_group(first, prims[p].wave_count);
        continue;
      }
      for (uint32_t w = 0; w < prims[p].wave_count; ++w) {
        wave_ = first + uint64_t{w} * code_.wave_stride_bytes;
        clear_locals();
        block(code_.wave, mask_of(wave_));
      }
    }
  }

 private:
  uint64_t* at(Slot slot) { return current_ + slot; }
  void clear_locals() { std::fill(current_ + code_.locals_begin, current_ + code_.value_count, 0); }
  static Mask mask_of(const void* wave) {
    return static_cast<Mask>(DirectMemory().load(reinterpret_cast<uint64_t>(wave), 4)) & kAllActive;
  }
  void fill(Slot slot, uint64_t raw) { std::fill_n(at(slot), kLanes, raw); }
  void fill(Slot slot, const void* pointer) { fill(slot, reinterpret_cast<uint64_t>(pointer)); }

  static bool active(Mask mask, uint32_t lane) { return (mask >> lane & 1) != 0; }

  void copy(const std::vector<Copy>& copies, Mask mask) {
    for (const Copy& c : copies) {
      for (uint32_t l = 0; l < kLanes; ++l) {
        if (active(mask, l)) at(c.to)[l] = at(c.from)[l];
      }
    }
  }

  Mask lanes_where(Slot b1, Mask mask) {
    Mask out = 0;
    for (uint32_t l = 0; l < kLanes; ++l) out |= static_cast<Mask>(at(b1)[l] & 1) << l;
    return out & mask;
  }

  void block(uint32_t index, Mask mask) { steps(code_.blocks[index].steps, mask); }

  void steps(std::span<const Step> all, Mask mask) {
    for (const Step& s : all) {
      if (s.fn != nullptr) {
        s.fn(at(s.out), at(s.in[0]), at(s.in[1]), at(s.in[2]));
      } else {
        step(s, mask);
      }
    }
  }

  void step(const Step& s, Mask mask) {
    switch (s.op) {
      case Op::kDrawPtr:
        return fill(s.out, draw_);
      case Op::kThreadPtr:
        return fill(s.out, thread_);
      case Op::kPrimPtr:
        return fill(s.out, prim_);
      case Op::kWavePtr:
        return fill(s.out, wave_);
      case Op::kLane:
        for (uint32_t l = 0; l < kLanes; ++l) at(s.out)[l] = l;
        return;
      case Op::kBallot:
        return fill(s.out, static_cast<uint64_t>(lanes_where(s.in[0], mask)));
      case Op::kQuadSwizzle:
        return quad_swizzle(s);
      case Op::kShuffle:
        return shuffle(s, mask);
      case Op::kReduce:
        return reduce(s, mask);
      case Op::kLoad:
        return load(s, mask);
      case Op::kStore:
        return store(s, mask);
      case Op::kAtomic:
        return s.type == ir::Type::kI64 ? atomic<uint64_t>(s, mask) : atomic<uint32_t>(s, mask);
      case Op::kCall:
        return call(s, mask);
      case Op::kLocalLoad:
        return local_load(s);
      case Op::kLocalStore:
        return local_store(s, mask);
      case Op::kIf:
        return if_else(s, mask);
      case Op::kLoop:
        return loop(s, mask);
      default:
        return;  // flatten() gives every other operation a LaneFn
    }
  }

  void quad_swizzle(const Step& s) {
    std::array<uint64_t, kLanes> in;
    std::copy_n(at(s.in[0]), kLanes, in.begin());
    for (uint32_t l = 0; l < kLanes; ++l) at(s.out)[l] = in[(l & ~3u) | (s.imm >> (2 * (l & 3)) & 3)];
  }

  void shuffle(const Step& s, Mask mask) {
    std::array<uint64_t, kLanes> in;
    std::copy_n(at(s.in[0]), kLanes, in.begin());
    for (uint32_t l = 0; l < kLanes; ++l) {
      const auto from = static_cast<uint32_t>(at(s.in[1])[l] % kLanes);
      at(s.out)[l] = active(mask, from) ? in[from] : 0;
    }
  }

  // See ir.h, "Subgroups".
  void reduce(const Step& s, Mask mask) {
    const uint32_t cluster = 1u << (s.imm >> 16);
    const auto scan = static_cast<ir::Scan>(s.imm >> 8 & 0xff);
    std::array<uint64_t, kLanes> x, other, combined;
    for (uint32_t l = 0; l < kLanes; ++l) x[l] = active(mask, l) ? at(s.in[0])[l] : s.identity;
    if (scan == ir::Scan::kReduce) {
      for (uint32_t step = cluster / 2; step > 0; step /= 2) {
        for (uint32_t l = 0; l < kLanes; ++l) other[l] = x[(l & ~(cluster - 1)) | ((l + step) & (cluster - 1))];
        s.combine(x.data(), x.data(), other.data(), nullptr);
      }
      for (uint32_t l = 0; l < kLanes; ++l) at(s.out)[l] = x[l & ~(cluster - 1)];
      return;
    }
    for (uint32_t step = 1; step < cluster; step *= 2) {
      for (uint32_t l = 0; l < kLanes; ++l) other[l] = x[l >= step ? l - step : l];
      s.combine(combined.data(), other.data(), x.data(), nullptr);
      for (uint32_t l = 0; l < kLanes; ++l) x[l] = l % cluster >= step ? combined[l] : x[l];
    }
    const bool exclusive = scan == ir::Scan::kExclusive;
    for (uint32_t l = 0; l < kLanes; ++l) at(s.out)[l] = !exclusive ? x[l] : l % cluster == 0 ? s.first : x[l - 1];
  }

  // Whether a checked access may take place, and where. Checks in 64 bits: nothing wraps.
  struct Access {
    bool allowed;
    uint64_t address;
  };
  Access access(const Step& s, uint32_t lane, uint32_t size_bytes, Slot limit) {
    const uint64_t offset = at(s.in[1])[lane] + lane * (s.imm >> 32);
    return {limit == 0 || offset + size_bytes <= at(limit)[lane], at(s.in[0])[lane] + offset};
  }

  void load(const Step& s, Mask mask) {
    if (s.flags & ir::kSpeculate) mask = kAllActive;
    const uint32_t size = ir::size_bytes(s.type);
    for (uint32_t l = 0; l < kLanes; ++l) {
      uint64_t bits = 0;
      if (active(mask, l)) {
        const Access where = access(s, l, size, s.in[2]);
        if (where.allowed) bits = memory_.load(where.address, size);
      }
      at(s.out)[l] = ir::memory_raw(s.type, bits, code_.floats);
    }
  }

  void store(const Step& s, Mask mask) {
    if (s.flags & ir::kAllLanes) mask = kAllActive;
    const uint32_t size = ir::size_bytes(s.type);
    for (uint32_t l = 0; l < kLanes; ++l) {
      if (!active(mask, l)) continue;
      const Access where = access(s, l, size, s.in[3]);
      if (where.allowed) memory_.store(where.address, size, ir::raw_memory(s.type, at(s.in[2])[l], code_.floats));
    }
  }

  template <class U>
  void atomic(const Step& s, Mask mask) {
    const auto op = static_cast<ir::AtomicOp>(s.imm & 0xff);
    for (uint32_t l = 0; l < kLanes; ++l) {
      uint64_t old = 0;
      if (active(mask, l)) {
        const Access where = access(s, l, sizeof(U), s.in[3]);
        const auto value = static_cast<U>(at(s.in[2])[l]), comparand = static_cast<U>(at(s.in[4])[l]);
        if (where.allowed) old = memory_.template atomic<U>(where.address, op, value, comparand);
      }
      at(s.out)[l] = old;
    }
  }

  // The callee runs on a copy of its record, so that it sees an overlay's bytes, and the overlay what it changes.
  void call(const Step& s, Mask mask) {
    if (mask == 0) return;
    const auto lane = static_cast<uint32_t>(std::countr_zero(mask));
    const uint64_t address = at(s.in[1])[lane];
    alignas(64) std::array<uint8_t, ir::kMaxRecordBytes> before, record;
    for (uint64_t i = 0; i < s.imm; ++i) before[i] = static_cast<uint8_t>(memory_.load(address + i, 1));
    std::copy_n(before.begin(), s.imm, record.begin());
    const auto& handle = *reinterpret_cast<const KernelHandle*>(at(s.in[0])[lane]);
    const PrimRecord prim{nullptr, 0, 1};
    handle(draw_, thread_, &prim, 1, record.data());
    for (uint64_t i = 0; i < s.imm; ++i) {
      if (record[i] != before[i]) memory_.store(address + i, 1, record[i]);
    }
  }

  void local_load(const Step& s) {
    for (uint32_t l = 0; l < kLanes; ++l) {
      const uint64_t index = at(s.in[1])[l];
      at(s.out)[l] = index < s.imm ? at(s.in[0])[index * kLanes + l] : 0;
    }
  }

  void local_store(const Step& s, Mask mask) {
    for (uint32_t l = 0; l < kLanes; ++l) {
      const uint64_t index = at(s.in[1])[l];
      if (active(mask, l) && index < s.imm) at(s.in[0])[index * kLanes + l] = at(s.in[2])[l];
    }
  }

  void if_else(const Step& s, Mask mask) {
    const Mask taken = lanes_where(s.in[0], mask);
    const Mask sides[2] = {taken, mask & ~taken};
    for (int side = 0; side < 2; ++side) {
      if (sides[side] == 0) continue;
      block(s.block[side], sides[side]);
      copy(code_.blocks[s.block[side]].yields, sides[side]);
    }
  }

  void loop(const Step& s, Mask mask) {
    const Block& body = code_.blocks[s.block[0]];
    copy(body.initial, kAllActive);
    while (mask != 0) {
      block(s.block[0], mask);
      copy(body.yields, mask);  // all of them before any LoopArg changes: they may name LoopArgs
      mask = lanes_where(body.again, mask);
      copy(body.carried, mask);
      if (kernels_stopped()) return;
    }
  }

  // ---- kernels with barriers: all waves of a primitive together ----
  // Each wave has values of its own, which begin as a copy of the draw's and the primitive's.

  void run_group(const uint8_t* first_wave, uint32_t wave_count) {
    group_.assign(wave_count * code_.value_count, 0);
    group_waves_ = first_wave;
    std::vector<Mask> masks(wave_count);
    for (uint32_t w = 0; w < wave_count; ++w) {
      std::copy_n(values_.get(), code_.value_count, group_.data() + w * code_.value_count);
      select_wave(w);
      clear_locals();
      masks[w] = mask_of(wave_);
    }
    group_block(code_.wave, masks);
    current_ = values_.get();
  }

  void select_wave(size_t w) {
    current_ = group_.data() + w * code_.value_count;
    wave_ = group_waves_ + w * code_.wave_stride_bytes;
  }

  // fn(mask) for each wave that has active lanes.
  template <class Fn>
  void for_each_wave(std::vector<Mask>& masks, Fn&& fn) {
    for (size_t w = 0; w < masks.size(); ++w) {
      if (masks[w] == 0) continue;
      select_wave(w);
      fn(masks[w]);
    }
  }

  void group_block(uint32_t index, std::vector<Mask>& masks) {
    const std::vector<Step>& all = code_.blocks[index].steps;
    for (size_t begin = 0; begin < all.size();) {
      size_t end = begin;
      while (end < all.size() && all[end].op != Op::kBarrier && !all[end].for_group) ++end;
      for_each_wave(masks, [&](Mask mask) { steps({all.data() + begin, end - begin}, mask); });
      if (end < all.size() && all[end].op == Op::kIf) group_if(all[end], masks);
      if (end < all.size() && all[end].op == Op::kLoop) group_loop(all[end], masks);
      begin = end + 1;
    }
  }

  void group_if(const Step& s, std::vector<Mask>& masks) {
    std::vector<Mask> sides[2] = {masks, masks};
    for (size_t w = 0; w < masks.size(); ++w) {
      select_wave(w);
      sides[0][w] = lanes_where(s.in[0], masks[w]);
      sides[1][w] = masks[w] & ~sides[0][w];
    }
    for (int side = 0; side < 2; ++side) {
      group_block(s.block[side], sides[side]);
      for_each_wave(sides[side], [&](Mask mask) { copy(code_.blocks[s.block[side]].yields, mask); });
    }
  }

  void group_loop(const Step& s, std::vector<Mask> masks) {
    const Block& body = code_.blocks[s.block[0]];
    for_each_wave(masks, [&](Mask) { copy(body.initial, kAllActive); });
    while (std::ranges::any_of(masks, [](Mask mask) { return mask != 0; })) {
      group_block(s.block[0], masks);
      for_each_wave(masks, [&](Mask& mask) {
        copy(body.yields, mask);
        mask = lanes_where(body.again, mask);
        copy(body.carried, mask);
      });
      if (kernels_stopped()) return;
    }
  }

  const Code& code_;
  Memory& memory_;
  std::unique_ptr<uint64_t[]> values_;
  uint64_t* current_ = values_.get();  // the values being computed: values_, or those of a wave in group_
  std::vector<uint64_t> group_;        // by wave of the workgroup
  const uint8_t* group_waves_ = nullptr;
  const void* draw_ = nullptr;
  void* thread_ = nullptr;
  const void* prim_ = nullptr;
  const void* wave_ = nullptr;
};

}  // namespace

Program::Program(const ir::Kernel& kernel, Mode mode) : code_(std::make_unique<const Code>(flatten(kernel, mode))) {}
Program::~Program() = default;
Program::Program(Program&&) noexcept = default;
Program& Program::operator=(Program&&) noexcept = default;

void Program::run(const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count, const void* waves) const {
  const ScopedFloatEnvironment environment;
  DirectMemory memory;
  Machine(*code_, memory).run(draw, thread, prims, prim_count, waves);
}

std::vector<WrittenByte> Program::dry_run(const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
                                          const void* waves) const {
  const ScopedFloatEnvironment environment;
  OverlayMemory memory;
  Machine(*code_, memory).run(draw, thread, prims, prim_count, waves);
  return memory.take();
}

void Program::invoke(const KernelHandle* handle, const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
                     const void* waves) {
  static_cast<const Program*>(handle->self)->run(draw, thread, prims, prim_count, waves);
}

void run(const ir::Kernel& kernel, Mode mode, const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
         const void* waves) {
  Program(kernel, mode).run(draw, thread, prims, prim_count, waves);
}

std::vector<WrittenByte> dry_run(const ir::Kernel& kernel, const void* draw, void* thread, const PrimRecord* prims,
                                 uint32_t prim_count, const void* waves) {
  return Program(kernel, Mode::kF32).dry_run(draw, thread, prims, prim_count, waves);
}

}  // namespace pineda::eval
