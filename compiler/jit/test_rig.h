// Shared by the tests of the back end: runs a kernel on every ISA that this CPU has and on the evaluator, and compares the memory
// they leave.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <random>
#include <vector>

#include "compiler/eval/eval.h"
#include "compiler/ir/builder.h"
#include "compiler/jit/jit.h"

namespace pineda::jit::test {

inline std::vector<Isa> isas() {
  std::vector<Isa> out;
  for (Isa isa : {Isa::kSse42, Isa::kAvx2, Isa::kAvx512}) {
    if (isa_supported(isa)) out.push_back(isa);
  }
  return out;
}

// A compiled kernel, released at the end of its life.
class Compiled {
 public:
  Compiled(const ir::Kernel& kernel, Options options) {
    std::string error;
    api_ = api(&error);
    if (api_ == nullptr) {
      code.error = error;
    } else {
      code = api_->compile(kernel, options);
    }
  }
  ~Compiled() {
    if (code.owner != nullptr) api_->release(code.owner);
  }
  Compiled(const Compiled&) = delete;
  Compiled& operator=(const Compiled&) = delete;

  Code code;

 private:
  const Api* api_ = nullptr;
};

// One call of a kernel: what it reads and writes.
struct Call {
  const void* draw = nullptr;
  void* thread = nullptr;
  std::vector<PrimRecord> prims;
  const void* waves = nullptr;
  void* memory = nullptr;  // what the kernel may write; compared afterwards, and restored before each run
  size_t memory_bytes = 0;
};

inline std::vector<uint8_t> snapshot(const Call& call) {
  const auto* bytes = static_cast<const uint8_t*>(call.memory);
  return {bytes, bytes + call.memory_bytes};
}

// The index of the first byte that differs, or -1.
inline ptrdiff_t first_difference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] != b[i]) return static_cast<ptrdiff_t>(i);
  }
  return -1;
}

// Runs the kernel on the evaluator, then on each ISA from the same initial memory. `describe` explains a differing byte.
inline void expect_same(const ir::Kernel& kernel, const Call& call,
                        const std::function<std::string(size_t byte)>& describe = nullptr) {
  ASSERT_EQ(ir::verify(kernel), "") << ir::print(kernel);
  const std::vector<uint8_t> before = snapshot(call);
  eval::run(kernel, eval::Mode::kF32, call.draw, call.thread, call.prims.data(), static_cast<uint32_t>(call.prims.size()),
            call.waves);
  const std::vector<uint8_t> expected = snapshot(call);
  for (Isa isa : isas()) {
    const Compiled compiled(kernel, {.isa = isa});
    ASSERT_EQ(compiled.code.error, "") << isa_name(isa) << "\n" << ir::print(kernel);
    std::memcpy(call.memory, before.data(), before.size());
    const KernelHandle handle{compiled.code.fn, nullptr};
    handle(call.draw, call.thread, call.prims.data(), static_cast<uint32_t>(call.prims.size()), call.waves);
    const std::vector<uint8_t> got = snapshot(call);
    const ptrdiff_t byte = first_difference(expected, got);
    if (byte < 0) continue;
    std::string text = describe ? describe(static_cast<size_t>(byte)) : "";
    ADD_FAILURE() << isa_name(isa) << " differs from the evaluator at byte " << byte << ": " << int{got[byte]} << " instead of "
                  << int{expected[byte]} << " " << text << "\n"
                  << ir::print(kernel);
  }
  std::memcpy(call.memory, before.data(), before.size());
}

}  // namespace pineda::jit::test
