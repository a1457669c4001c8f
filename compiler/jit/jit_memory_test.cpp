// Loads, stores and atomics in every address form, under masks and limits, between two unmapped pages: a lane that is off, or out
// of bounds, must not touch memory, and what is read must be what the evaluator reads.
#include <sys/mman.h>

#include <chrono>
#include <thread>

#include "compiler/jit/test_rig.h"
#include "compiler/passes/passes.h"

namespace pineda::jit::test {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;

constexpr uint32_t kSeed = 77;
constexpr uint32_t kPageBytes = 4096;
constexpr Type kTypes[] = {Type::kI8, Type::kI16, Type::kF16, Type::kI32, Type::kF32, Type::kI64, Type::kF64};

// One page of memory that faults on both sides.
class GuardedPage {
 public:
  GuardedPage() {
    void* all = mmap(nullptr, 3 * kPageBytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    begin_ = static_cast<uint8_t*>(all) + kPageBytes;
    mprotect(begin_, kPageBytes, PROT_READ | PROT_WRITE);
    std::mt19937 rng(kSeed);
    for (uint32_t i = 0; i < kPageBytes; ++i) begin_[i] = static_cast<uint8_t>(rng());
  }
  ~GuardedPage() { munmap(begin_ - kPageBytes, 3 * kPageBytes); }
  GuardedPage(const GuardedPage&) = delete;
  GuardedPage& operator=(const GuardedPage&) = delete;
  uint8_t* begin() const { return begin_; }

 private:
  uint8_t* begin_;
};

struct MemoryWave {
  uint32_t mask;
  uint32_t limit;
  uint64_t base;
  uint64_t out;
  uint32_t uniform_offset;
  uint32_t reserved;
  uint32_t lane_offset[kLanes];
  uint32_t lane_limit[kLanes];
};

enum class Form { kUniform, kContiguous, kStrided, kGather, kGatherStrided, kLaneBase, kLaneLimit };
constexpr Form kForms[] = {Form::kUniform,       Form::kContiguous, Form::kStrided,  Form::kGather,
                           Form::kGatherStrided, Form::kLaneBase,   Form::kLaneLimit};

struct Shape {
  Form form;
  Type type;
  bool checked, masked;
  uint32_t size() const { return ir::size_bytes(type); }
  uint32_t stride() const {
    return form == Form::kContiguous ? size() : form == Form::kStrided ? 12 : form == Form::kGatherStrided ? 2 * size() : 0;
  }
};

std::string describe_shape(const Shape& s) {
  return "form " + std::to_string(static_cast<int>(s.form)) + " " + ir::type_name(s.type) + (s.checked ? " checked" : "") +
         (s.masked ? " masked" : "");
}

// Addresses such that exactly the lanes that are on and within their limit lie in the page, as often as possible at its very
// ends.
class WaveMaker {
 public:
  WaveMaker(const GuardedPage& page, const Shape& shape) : page_(page), shape_(shape), rng_(kSeed) {}

  MemoryWave make() {
    MemoryWave w{.mask = shape_.masked ? below(0x10000) : 0xffff, .base = reinterpret_cast<uint64_t>(page_.begin())};
    if (shape_.masked && w.mask == 0) w.mask = 1;
    w.limit = shape_.checked ? (below(4) == 0 ? below(kPageBytes + 1) : kPageBytes) : 0;
    const uint32_t span = shape_.size() + (kLanes - 1) * shape_.stride();
    const uint32_t last = kPageBytes - span;
    w.uniform_offset = pick(last);
    if (shape_.checked && below(2) == 0) w.uniform_offset = kPageBytes - below(span + 8);  // some lanes out of bounds
    if (shape_.checked && below(8) == 0) w.uniform_offset = ~below(40);
    if (!shape_.checked && shape_.masked && shape_.stride() != 0) hang_over_an_end(w);
    for (uint32_t l = 0; l < kLanes; ++l) {
      w.lane_offset[l] = pick(kPageBytes - shape_.size() - l * shape_.stride());
      w.lane_limit[l] = below(3) == 0 ? below(kPageBytes + 1) : kPageBytes;
      const bool harmless = shape_.checked || (shape_.masked && (w.mask >> l & 1) == 0);
      if (harmless && below(3) == 0) w.lane_offset[l] = below(2) == 0 ? ~below(80) : 0x7ffffff0 + below(0x1000000);
    }
    if (shape_.form == Form::kLaneBase) w.uniform_offset = 0;
    return w;
  }

 private:
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(rng_() % n); }
  uint32_t pick(uint32_t last) {
    switch (below(4)) {
      case 0:
        return below(4);
      case 1:
        return last - below(4);
      default:
        return below(last + 1);
    }
  }
  // Lanes below the first active one, or above the last, are in the unmapped pages.
  void hang_over_an_end(MemoryWave& w) {
    const uint32_t first = static_cast<uint32_t>(__builtin_ctz(w.mask)), last = 31 - static_cast<uint32_t>(__builtin_clz(w.mask));
    w.uniform_offset = 0;
    if (below(2) == 0) {
      w.base -= first * shape_.stride();
    } else {
      w.uniform_offset = kPageBytes - shape_.size() - last * shape_.stride();
    }
  }

  const GuardedPage& page_;
  Shape shape_;
  std::mt19937_64 rng_;
};

struct MemoryKernel {
  explicit MemoryKernel(const Shape& s) : shape(s) {
    kernel.name = "memory";
    kernel.wave_stride_bytes = sizeof(MemoryWave);
  }
  ir::Address address(Builder& b) const {
    const auto per_lane = [&](uint32_t at) {
      return b.load(Type::kI32, {.base = b.wave_ptr(), .offset = b.i32(at), .lane_stride = 4});
    };
    const auto uniform = [&](Type t, size_t at) { return b.load(t, b.wave_ptr(), static_cast<uint32_t>(at), ir::kSpeculate); };
    ir::Address a{.base = uniform(Type::kPtr, offsetof(MemoryWave, base)), .lane_stride = shape.stride()};
    const bool lanes = shape.form == Form::kGather || shape.form == Form::kGatherStrided || shape.form == Form::kLaneLimit;
    a.offset = lanes ? per_lane(offsetof(MemoryWave, lane_offset)) : uniform(Type::kI32, offsetof(MemoryWave, uniform_offset));
    if (shape.form == Form::kLaneBase) {
      // Lanes that are off may have any base; those that are on must have a good one, limit or not.
      a.base = b.ptr_add(a.base, per_lane(offsetof(MemoryWave, lane_offset)));
    }
    if (shape.checked) a.limit = uniform(Type::kI32, offsetof(MemoryWave, limit));
    if (shape.checked && shape.form == Form::kLaneLimit) a.limit = per_lane(offsetof(MemoryWave, lane_limit));
    return a;
  }
  Value out(Builder& b) const { return b.load(Type::kPtr, b.wave_ptr(), offsetof(MemoryWave, out)); }

  Shape shape;
  ir::Kernel kernel;
};

template <typename Fn>
void for_each_shape(Fn&& fn) {
  for (Form form : kForms) {
    for (Type type : kTypes) {
      for (bool checked : {false, true}) {
        for (bool masked : {false, true}) {
          if (form == Form::kLaneBase && checked) continue;  // a limit says nothing about a base that is wrong itself
          const Shape shape{form, type, checked, masked};
          SCOPED_TRACE(describe_shape(shape));
          fn(shape);
          if (::testing::Test::HasFailure()) return;
        }
      }
    }
  }
}

std::vector<MemoryWave> make_waves(const GuardedPage& page, const Shape& shape, uint32_t count) {
  WaveMaker maker(page, shape);
  std::vector<MemoryWave> waves;
  for (uint32_t i = 0; i < count; ++i) waves.push_back(maker.make());
  return waves;
}

TEST(JitMemory, Loads) {
  const GuardedPage page;
  constexpr uint32_t kWaves = 48;
  for_each_shape([&](const Shape& shape) {
    std::vector<MemoryWave> waves = make_waves(page, shape, kWaves);
    std::vector<uint8_t> out(kWaves * kLanes * 8);
    for (uint32_t i = 0; i < kWaves; ++i) waves[i].out = reinterpret_cast<uint64_t>(out.data() + i * kLanes * 8);
    MemoryKernel m(shape);
    Builder b(m.kernel);
    const Value loaded = b.load(shape.type, m.address(b));
    b.store({.base = m.out(b), .offset = b.imul(b.lane(), b.i32(8))}, loaded);
    passes::rates(m.kernel);
    expect_same(m.kernel,
                {.prims = {{nullptr, 0, kWaves}}, .waves = waves.data(), .memory = out.data(), .memory_bytes = out.size()});
  });
}

TEST(JitMemory, Stores) {
  const GuardedPage page;
  constexpr uint32_t kWaves = 48;
  for_each_shape([&](const Shape& shape) {
    const std::vector<MemoryWave> waves = make_waves(page, shape, kWaves);
    MemoryKernel m(shape);
    Builder b(m.kernel);
    const Value lane_value = b.iadd(b.imul(b.lane(), b.i32(0x01010101)), b.i32(0x10));
    Value value = lane_value;
    if (shape.size() > 4) value = b.convert(ir::Op::kZExt, Type::kI64, value);
    if (shape.size() == 2) value = b.convert(ir::Op::kTrunc, Type::kI16, value);
    if (shape.size() == 1) value = b.convert(ir::Op::kTrunc, Type::kI8, value);
    if (ir::is_float(shape.type)) value = b.bitcast(shape.type, value);
    b.store(m.address(b), value);
    passes::rates(m.kernel);
    expect_same(m.kernel,
                {.prims = {{nullptr, 0, kWaves}}, .waves = waves.data(), .memory = page.begin(), .memory_bytes = kPageBytes});
  });
}

TEST(JitMemory, UniformStoresHappenOnce) {
  const GuardedPage page;
  const Shape shape{Form::kUniform, Type::kI32, true, true};
  const std::vector<MemoryWave> waves = make_waves(page, shape, 64);
  MemoryKernel m(shape);
  Builder b(m.kernel);
  b.if_(b.ult(b.lane(), b.i32(3)), [&] { b.store(m.address(b), b.load(Type::kI32, b.wave_ptr(), 0)); });
  passes::rates(m.kernel);
  expect_same(m.kernel, {.prims = {{nullptr, 0, 64}}, .waves = waves.data(), .memory = page.begin(), .memory_bytes = kPageBytes});
}

// The mask narrowed by an If, and values loaded under it used outside by their lanes only.
TEST(JitMemory, UnderDivergentControl) {
  const GuardedPage page;
  for (Type type : kTypes) {
    for (Form form : {Form::kContiguous, Form::kGather}) {
      const Shape shape{form, type, true, true};
      SCOPED_TRACE(describe_shape(shape));
      constexpr uint32_t kWaves = 32;
      std::vector<MemoryWave> waves = make_waves(page, shape, kWaves);
      std::vector<uint8_t> out(kWaves * kLanes * 8);
      for (uint32_t i = 0; i < kWaves; ++i) waves[i].out = reinterpret_cast<uint64_t>(out.data() + i * kLanes * 8);
      MemoryKernel m(shape);
      Builder b(m.kernel);
      const Value odd = b.ine(b.and_(b.lane(), b.i32(1)), b.i32(0));
      const auto r = b.if_else(
          odd, {type}, [&] { return std::vector{b.load(type, m.address(b))}; }, [&] { return std::vector{b.zero(type)}; });
      b.store({.base = m.out(b), .lane_stride = 8}, r[0]);
      passes::rates(m.kernel);
      expect_same(m.kernel,
                  {.prims = {{nullptr, 0, kWaves}}, .waves = waves.data(), .memory = out.data(), .memory_bytes = out.size()});
    }
  }
}

TEST(JitMemory, AllLanesStoreIgnoresTheMask) {
  const GuardedPage page;
  for (Type type : kTypes) {
    const Shape shape{Form::kContiguous, type, false, false};
    std::vector<MemoryWave> waves = make_waves(page, shape, 8);
    for (MemoryWave& w : waves) w.mask = 0x00f1;
    MemoryKernel m(shape);
    Builder b(m.kernel);
    b.store(m.address(b), b.zero(type), ir::kAllLanes);
    passes::rates(m.kernel);
    expect_same(m.kernel,
                {.prims = {{nullptr, 0, 8}}, .waves = waves.data(), .memory = page.begin(), .memory_bytes = kPageBytes});
  }
}

TEST(JitMemory, Atomics) {
  const GuardedPage page;
  constexpr uint32_t kWaves = 16;
  for (Type type : {Type::kI32, Type::kI64}) {
    for (int op = 0; op <= static_cast<int>(ir::AtomicOp::kCompareExchange); ++op) {
      for (Form form : {Form::kUniform, Form::kContiguous, Form::kGather, Form::kLaneBase}) {
        const Shape shape{form, type, form != Form::kLaneBase, true};
        SCOPED_TRACE(describe_shape(shape) + " op " + std::to_string(op));
        std::vector<MemoryWave> waves = make_waves(page, shape, kWaves);
        for (uint32_t i = 0; i < kWaves; ++i) {
          waves[i].out = reinterpret_cast<uint64_t>(page.begin() + 2048 + i * kLanes * 8);
          waves[i].limit = std::min(waves[i].limit, 2048u);
          waves[i].uniform_offset &= ~7u;
          for (uint32_t& offset : waves[i].lane_offset) offset = offset % (form == Form::kLaneBase ? 2048 : ~0u) & ~7u;
        }
        MemoryKernel m(shape);
        Builder b(m.kernel);
        Value value = b.imul(b.lane(), b.i32(0x23456789));
        if (type == Type::kI64) value = b.convert(ir::Op::kSExt, type, value);
        const bool compare = op == static_cast<int>(ir::AtomicOp::kCompareExchange);
        const Value comparand = compare ? b.constant(type, 0) : Value{};
        // Once more on what the first one left, so that the exchange finds its comparand.
        b.atomic(static_cast<ir::AtomicOp>(op), m.address(b), value, comparand);
        if (compare) b.store({.base = b.ptr_add(m.out(b), b.i32(0)), .lane_stride = 8}, b.constant(type, 0));
        const Value old = b.atomic(static_cast<ir::AtomicOp>(op), m.address(b), value, comparand);
        b.store({.base = m.out(b), .lane_stride = 8}, old);
        passes::rates(m.kernel);
        // The page ends with results; zeros in its first part let compare-exchange succeed in places.
        std::memset(page.begin(), 0, 1024);
        expect_same(m.kernel,
                    {.prims = {{nullptr, 0, kWaves}}, .waves = waves.data(), .memory = page.begin(), .memory_bytes = kPageBytes});
      }
    }
  }
}

// Offsets beyond 2 GiB and the 32-bit wrap of offset + stride, with memory that is really there.
TEST(JitMemory, LargeOffsets) {
  constexpr uint64_t kBytes = (uint64_t{1} << 32) + 65536;
  void* all = mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (all == MAP_FAILED) GTEST_SKIP() << "no 4 GiB of address space";
  auto* bytes = static_cast<uint8_t*>(all);
  const uint32_t places[] = {0, 4, 0x7ffffff8, 0x7ffffffc, 0x80000000, 0x80000004, 0xfffffff0, 0xfffffff8};
  for (uint32_t p : places) std::memset(bytes + p, static_cast<int>(p >> 3 & 0xff) + 1, 8);
  std::memset(bytes + (uint64_t{1} << 32), 0x77, 128);
  for (Type type : {Type::kI8, Type::kI16, Type::kI32, Type::kI64}) {
    for (Form form : {Form::kContiguous, Form::kStrided, Form::kGather, Form::kGatherStrided}) {
      for (bool checked : {false, true}) {
        const Shape shape{form, type, checked, false};
        SCOPED_TRACE(describe_shape(shape));
        std::vector<MemoryWave> waves;
        std::vector<uint8_t> out(std::size(places) * kLanes * 8);
        for (uint32_t p : places) {
          MemoryWave w{.mask = 0xffff, .limit = 0xffffffff, .base = reinterpret_cast<uint64_t>(bytes), .uniform_offset = p};
          w.out = reinterpret_cast<uint64_t>(out.data() + waves.size() * kLanes * 8);
          for (uint32_t l = 0; l < kLanes; ++l) w.lane_offset[l] = places[(waves.size() + l) % std::size(places)];
          waves.push_back(w);
        }
        MemoryKernel m(shape);
        Builder b(m.kernel);
        b.store({.base = m.out(b), .lane_stride = 8}, b.load(type, m.address(b)));
        passes::rates(m.kernel);
        expect_same(m.kernel, {.prims = {{nullptr, 0, static_cast<uint32_t>(waves.size())}},
                               .waves = waves.data(),
                               .memory = out.data(),
                               .memory_bytes = out.size()});
      }
    }
  }
  munmap(all, kBytes);
}

TEST(JitMemory, Locals) {
  struct Wave {
    uint32_t mask = 0xffff;
    uint32_t uniform_index = 0;
    uint32_t index[kLanes];
    uint32_t out[8][kLanes] = {};
  };
  for (uint32_t count : {1u, 2u, 5u, 40u}) {
    for (Type type : {Type::kB1, Type::kI8, Type::kI16, Type::kI32, Type::kF32, Type::kI64, Type::kPtr}) {
      SCOPED_TRACE(std::string(ir::type_name(type)) + " x " + std::to_string(count));
      std::mt19937 rng(kSeed);
      std::vector<Wave> waves(12);
      for (Wave& w : waves) {
        w.mask = rng() | 0x10;
        w.uniform_index = rng() % (count + 1);
        for (uint32_t& i : w.index) i = rng() % 4 == 0 ? rng() : rng() % (count + 1);
      }
      ir::Kernel kernel{.name = "locals", .wave_stride_bytes = sizeof(Wave)};
      Builder b(kernel);
      const Value array = b.local(type, count);
      const Value index = b.load(Type::kI32, {.base = b.wave_ptr(), .offset = b.i32(offsetof(Wave, index)), .lane_stride = 4});
      const Value uniform = b.load(Type::kI32, b.wave_ptr(), offsetof(Wave, uniform_index));
      const auto value = [&](Value x) {
        switch (type) {
          case Type::kB1:
            return b.ult(x, b.i32(9));
          case Type::kI8:
          case Type::kI16:
            return b.convert(ir::Op::kTrunc, type, x);
          case Type::kI64:
            return b.convert(ir::Op::kZExt, type, x);
          case Type::kF32:
            return b.bitcast(type, x);
          case Type::kPtr:
            return b.ptr_add(b.zero(type), x);
          default:
            return x;
        }
      };
      uint32_t slot = 0;
      const auto put = [&](Value v) {
        Value bits = type == Type::kPtr || type == Type::kI64 ? b.convert(ir::Op::kTrunc, Type::kI32, b.bitcast(Type::kI64, v))
                     : type == Type::kF32                     ? b.bitcast(Type::kI32, v)
                     : type == Type::kI32                     ? v
                                                              : b.convert(ir::Op::kZExt, Type::kI32, v);
        b.store(
            {.base = b.wave_ptr(), .offset = b.i32(static_cast<uint32_t>(offsetof(Wave, out)) + slot++ * 64), .lane_stride = 4},
            bits);
      };
      put(b.local_load(array, index));
      b.local_store(array, index, value(b.lane()));
      put(b.local_load(array, uniform));
      b.if_(b.ult(b.lane(), b.i32(7)), [&] { b.local_store(array, uniform, value(b.imul(b.lane(), b.i32(3)))); });
      put(b.local_load(array, index));
      b.local_store(array, b.i32(0), value(uniform));
      b.local_store(array, b.i32(count), value(b.i32(3)));
      put(b.local_load(array, b.i32(0)));
      put(b.local_load(array, uniform));
      put(b.local_load(array, b.i32(count)));
      passes::rates(kernel);
      expect_same(kernel, {.prims = {{nullptr, 0, 12}},
                           .waves = waves.data(),
                           .memory = waves.data(),
                           .memory_bytes = waves.size() * sizeof(Wave)});
    }
  }
}

TEST(JitMemory, TooManyLocalsAreRefused) {
  ir::Kernel kernel{.name = "huge", .wave_stride_bytes = 4};
  Builder b(kernel);
  const Value array = b.local(Type::kI32, 65536);
  b.local_store(array, b.lane(), b.lane());
  const Compiled compiled(kernel, {});
  EXPECT_NE(compiled.code.error.find("private arrays"), std::string::npos) << compiled.code.error;
}

// A loop that only another thread's store can end: LLVM must neither merge the loads of its turns nor move them out.
TEST(JitMemory, VolatileLoadsSeeOtherThreads) {
  for (const bool gathers : {false, true}) {
    ir::Kernel kernel{.wave_stride_bytes = sizeof(MemoryWave)};
    Builder b(kernel);
    const Value base = b.load(Type::kPtr, b.wave_ptr(), offsetof(MemoryWave, base), ir::kInvariant | ir::kSpeculate);
    const Value offset = gathers ? b.shl(b.and_(b.lane(), b.i32(1)), b.i32(2)) : b.i32(0);
    b.loop({}, [&](std::span<const Value>) {
      const Value seen = b.load(Type::kI32, {.base = base, .offset = offset, .limit = b.i32(8)}, ir::kVolatile);
      return Builder::LoopStep{b.ieq(seen, b.i32(0)), {}};
    });
    passes::rates(kernel);
    for (Isa isa : isas()) {
      const Compiled compiled(kernel, {.isa = isa});
      ASSERT_EQ(compiled.code.error, "") << isa_name(isa);
      alignas(8) uint32_t words[2] = {0, 0};
      MemoryWave wave{.mask = 0xffff, .base = reinterpret_cast<uint64_t>(words)};
      std::thread other([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        for (uint32_t& w : words) __atomic_store_n(&w, 1, __ATOMIC_SEQ_CST);
      });
      const PrimRecord prim{nullptr, 0, 1};
      KernelHandle{compiled.code.fn, nullptr}(nullptr, nullptr, &prim, 1, &wave);  // or this never returns
      other.join();
    }
  }
}

}  // namespace
}  // namespace pineda::jit::test
