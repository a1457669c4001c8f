// What the translator's tests share: a stage whose inputs, outputs and buffers are plain memory, and runs in both modes of the
// evaluator.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/abi.h"
#include "compiler/eval/eval.h"
#include "compiler/passes/passes.h"
#include "compiler/spirv/translate.h"
#include "tests/shader_tools.h"

namespace pineda::spirv::test {

using namespace tests::tools;  // glsl(), assembly(), rewritten()

// Inputs and outputs are lists of per-lane words in the wave record, buffers a table that the draw pointer points to.
class FakeStage final : public StageInterface {
 public:
  using Input = std::function<uint32_t(uint32_t lane, const InterfaceScalar&)>;

  struct Buffer {
    Words words;
    uint32_t size_bytes = ~0u;  // ~0: all of words
  };
  struct Output {
    InterfaceScalar scalar;
    std::array<uint32_t, kLanes> value{};
  };

  Input input_value = [](uint32_t, const InterfaceScalar&) { return 0u; };
  static constexpr uint32_t kShared = 9000;
  std::map<uint32_t, Buffer> buffers;  // key: set * 100 + binding * 10 + array index; 9999: push constants
  std::vector<AddressRange> ranges;    // what physical pointers may reach
  uint32_t active = 0xffff, coverage = 0xffff;
  Words shared;
  std::vector<SampleRequest> samples;
  std::vector<ImageQuery> queries;
  std::vector<ImageAccess> loads, stores;
  std::vector<Output> outputs;
  uint32_t discarded = 0;  // lanes, after a run

  // ---- StageInterface ----
  ir::Value input(ir::Builder& b, const InterfaceScalar& in) override {
    const uint32_t slot = slots_++;
    inputs_.push_back(in);
    const ir::Type memory = in.type == ir::Type::kB1 ? ir::Type::kI32 : in.type;
    const ir::Value v = b.load(memory, {.base = b.wave_ptr(), .offset = b.i32(offset(slot)), .lane_stride = 4});
    return in.type == ir::Type::kB1 ? b.ine(v, b.i32(0)) : v;
  }
  void output(ir::Builder& b, const InterfaceScalar& out, ir::Value value) override {
    outputs.push_back({.scalar = out});
    output_slots_.push_back(slots_);
    b.store({.base = b.wave_ptr(), .offset = b.i32(offset(slots_++)), .lane_stride = 4}, as_word(b, value));
  }
  std::optional<BufferRef> buffer(ir::Builder& b, uint32_t set, uint32_t binding, ir::Value array_index) override {
    const uint32_t key = set == kPushConstants ? 9999 : set * 100 + binding * 10;
    if (!buffers.contains(key)) return std::nullopt;
    const ir::Value entry = b.imul(b.iadd(array_index, b.i32(key)), b.i32(sizeof(Entry)));
    const ir::Value base = b.load(ir::Type::kPtr, {.base = b.draw_ptr(), .offset = entry}, ir::kInvariant | ir::kSpeculate);
    const ir::Value size =
        b.load(ir::Type::kI32, {.base = b.draw_ptr(), .offset = b.iadd(entry, b.i32(8))}, ir::kInvariant | ir::kSpeculate);
    return BufferRef{.base = base, .size_bytes = size};
  }
  // A made-up texture: (u, v + 10 * w, LOD, depth reference + 100 * layer component).
  std::optional<std::array<ir::Value, 4>> sample(ir::Builder& b, const SampleRequest& r) override {
    samples.push_back(r);
    if (r.result == ir::Type::kI32 || r.lod_mode == LodMode::kFetch) {
      const auto part = [&](ir::Value v) { return v ? v : b.i32(0); };
      std::array<ir::Value, 4> out{part(r.coord[0]), part(r.coord[1]), part(r.coord[2]), part(r.lod)};
      if (r.result == ir::Type::kF32) {
        for (ir::Value& v : out) v = b.convert(ir::Op::kSToF, ir::Type::kF32, v);
      } else {
        for (ir::Value& v : out) v = b.type(v) == ir::Type::kF32 ? b.convert(ir::Op::kFToS, ir::Type::kI32, v) : v;
      }
      return out;
    }
    const auto part = [&](ir::Value v) { return v ? v : b.f32(0); };
    return std::array<ir::Value, 4>{part(r.coord[0]), b.fadd(part(r.coord[1]), b.fmul(b.f32(10), part(r.coord[2]))),
                                    part(r.lod ? r.lod : r.bias), part(r.depth_reference)};
  }
  std::optional<std::array<ir::Value, 4>> query(ir::Builder& b, const ImageQuery& q) override {
    queries.push_back(q);
    if (q.kind == ImageQuery::Kind::kLod) return std::array<ir::Value, 4>{q.coord[0], q.coord[1], b.f32(0), b.f32(0)};
    return std::array<ir::Value, 4>{b.i32(64), b.i32(32), b.i32(16), b.i32(12)};
  }
  std::optional<std::array<ir::Value, 4>> image_load(ir::Builder& b, const ImageAccess& a) override {
    loads.push_back(a);
    ir::Value x = a.coord[0];
    if (a.component == ir::Type::kF32) x = b.convert(ir::Op::kSToF, ir::Type::kF32, x);
    return std::array<ir::Value, 4>{x, x, x, x};
  }
  bool image_store(ir::Builder& b, const ImageAccess& a, std::span<const ir::Value> texel) override {
    stores.push_back(a);
    const BufferRef image = *buffer(b, 0, 9, b.i32(0));  // word x of "buffer" 0.9
    b.store({.base = image.base, .offset = b.shl(a.coord[0], b.i32(2)), .limit = image.size_bytes}, texel[0]);
    return true;
  }
  std::optional<ir::Address> image_texel(ir::Builder& b, const ImageAccess& a) override {  // of the same words
    loads.push_back(a);
    const BufferRef image = *buffer(b, 0, 9, b.i32(0));
    return ir::Address{.base = image.base, .offset = b.shl(a.coord[0], b.i32(2)), .limit = image.size_bytes};
  }
  ir::Value covered(ir::Builder& b) override {
    return b.unpack_mask(b.load(ir::Type::kI32, b.wave_ptr(), 4, ir::kInvariant | ir::kSpeculate));
  }
  ir::Value shared_memory(ir::Builder& b) override {
    buffers[kShared];
    return buffer(b, kShared / 100, 0, b.i32(0))->base;
  }

  static constexpr uint32_t kRanges = 9001;
  std::array<ir::Value, 2> address_ranges(ir::Builder& b) override {
    if (ranges.empty()) return {};
    const ir::Value entry = b.i32(kRanges * sizeof(Entry));
    return {b.load(ir::Type::kPtr, {.base = b.draw_ptr(), .offset = entry}, ir::kInvariant | ir::kSpeculate),
            b.i32(static_cast<uint32_t>(ranges.size()))};
  }

  // ---- running ----
  // Appends what is left of the kernel: stores of the discarded lanes.
  void finish(ir::Builder& b, const Translation& t) {
    if (!t.discarded) return;
    discard_slot_ = slots_++;
    b.store({.base = b.wave_ptr(), .offset = b.i32(offset(*discard_slot_)), .lane_stride = 4}, as_word(b, t.discarded));
  }
  static constexpr uint32_t kMaxSlots = 512;
  static constexpr uint32_t kRecordWords = 2 + kMaxSlots * kLanes;

  void run(const ir::Kernel& kernel, eval::Mode mode) {
    ASSERT_LE(slots_, kMaxSlots);
    std::vector<Entry> table(10016, Entry{});
    for (auto& [key, buffer] : buffers) {
      const uint32_t all = static_cast<uint32_t>(buffer.words.size()) * 4;
      table[key] = {reinterpret_cast<uint64_t>(buffer.words.data()), std::min(all, buffer.size_bytes), 0};
    }
    table[kShared] = {reinterpret_cast<uint64_t>(shared.data()), static_cast<uint32_t>(shared.size()) * 4, 0};
    table[kRanges] = {reinterpret_cast<uint64_t>(ranges.data()), static_cast<uint32_t>(ranges.size() * sizeof(AddressRange)), 0};
    Words record(kRecordWords, 0);
    record[0] = active;
    record[1] = coverage;
    for (uint32_t i = 0; i < inputs_.size(); ++i) {
      for (uint32_t lane = 0; lane < kLanes; ++lane) record[2 + i * kLanes + lane] = input_value(lane, inputs_[i]);
    }
    const PrimRecord prim{nullptr, 0, 1};
    eval::run(kernel, mode, table.data(), nullptr, &prim, 1, record.data());
    for (uint32_t i = 0; i < outputs.size(); ++i) {
      for (uint32_t lane = 0; lane < kLanes; ++lane) outputs[i].value[lane] = record[2 + output_slots_[i] * kLanes + lane];
    }
    discarded = 0;
    for (uint32_t lane = 0; discard_slot_ && lane < kLanes; ++lane) {
      discarded |= (record[2 + *discard_slot_ * kLanes + lane] & 1) << lane;
    }
  }

  // The output at a location, as words.
  const std::array<uint32_t, kLanes>& at(uint32_t location, uint32_t component = 0) const {
    for (const Output& o : outputs) {
      if (!o.scalar.built_in && o.scalar.location == location && o.scalar.component == component) return o.value;
    }
    ADD_FAILURE() << "no output at location " << location << "." << component;
    static const std::array<uint32_t, kLanes> kNone{};
    return kNone;
  }

 private:
  struct Entry {
    uint64_t address;
    uint32_t size_bytes, reserved;
  };
  static uint32_t offset(uint32_t slot) { return 8 + slot * kLanes * 4; }
  static ir::Value as_word(ir::Builder& b, ir::Value v) {
    return b.type(v) == ir::Type::kB1 ? b.convert(ir::Op::kZExt, ir::Type::kI32, v) : v;
  }

  uint32_t slots_ = 0;
  std::vector<InterfaceScalar> inputs_;
  std::vector<uint32_t> output_slots_;
  std::optional<uint32_t> discard_slot_;
};

inline std::string text_of(const CompileError& error) { return error.text; }

inline ir::KernelKind kind_of(VkShaderStageFlagBits stage) {
  if (stage == VK_SHADER_STAGE_VERTEX_BIT) return ir::KernelKind::kVertex;
  return stage == VK_SHADER_STAGE_FRAGMENT_BIT ? ir::KernelKind::kFragment : ir::KernelKind::kCompute;
}

struct Options {
  std::span<const SpecializationConstant> specialization{};
  eval::Mode mode = eval::Mode::kF32;
};

// Parses, translates, verifies, optimises, verifies and runs with `stage`. The module's error, or empty.
inline std::string run(FakeStage& fake, VkShaderStageFlagBits stage, const Words& words, const Options& options = {},
                       ModuleInfo* found = nullptr) {
  const auto module = parse({.words = words, .entry_point = "main", .stage = stage, .specialization = options.specialization});
  if (!module) return module.error().text;
  if (found) *found = info(**module);
  fake.shared.assign(info(**module).shared_memory_bytes / 4 + 1, 0);
  ir::Kernel kernel;
  kernel.kind = kind_of(stage);
  kernel.wave_stride_bytes = FakeStage::kRecordWords * 4;
  ir::Builder b(kernel);
  const auto translation = translate(**module, b, fake);
  if (!translation) return translation.error().text;
  fake.finish(b, *translation);
  EXPECT_EQ(ir::verify(kernel), "") << ir::print(kernel);
  passes::optimize(kernel, options.mode == eval::Mode::kF64 ? passes::Form::kTruth : passes::Form::kMachine);
  EXPECT_EQ(ir::verify(kernel), "") << ir::print(kernel);
  if (getenv("PINEDA_TEST_PRINT")) printf("%s\n", ir::print(kernel).c_str());
  fake.run(kernel, options.mode);
  return "";
}

inline uint32_t word(float v) { return std::bit_cast<uint32_t>(v); }
inline float real(uint32_t v) { return std::bit_cast<float>(v); }

// A compute shader of 16 invocations over `data`, which is binding 0: `buffer Data { uint/float d[]; }`. `lane` is the
// invocation's number.
inline Words compute_words(const std::string& body, const std::string& type = "uint", const std::string& globals = "") {
  return glsl(VK_SHADER_STAGE_COMPUTE_BIT, "layout(local_size_x = 16) in;\nlayout(std430, set = 0, binding = 0) buffer Data { " +
                                               type + " d[]; };\n" + globals +
                                               "\nvoid main() { uint lane = gl_LocalInvocationIndex;\n" + body + "\n}\n");
}

inline Words compute(const std::string& body, Words data, const std::string& type = "uint", const std::string& globals = "",
                     eval::Mode mode = eval::Mode::kF32) {
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar& s) { return s.component == 0 ? lane : 0u; };
  stage.buffers[0].words = std::move(data);
  EXPECT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, compute_words(body, type, globals), {.mode = mode}), "");
  return stage.buffers[0].words;
}

}  // namespace pineda::spirv::test
