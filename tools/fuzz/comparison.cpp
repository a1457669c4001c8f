#include "tools/fuzz/comparison.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>

#include "compiler/eval/eval.h"
#include "compiler/ir/random.h"
#include "compiler/ir/wave_frame.h"
#include "compiler/jit/jit.h"
#include "compiler/passes/passes.h"
#include "tools/fuzz/memory_stage.h"

namespace pineda::fuzz {
namespace {

using ir::Random;

constexpr uint32_t kBufferBytes = 4096;

// Everything that a run reads or writes, in one place, so that it can be copied back and compared.
struct Memory {
  Table table;
  WaveRecord wave;
  uint8_t buffers[Table::kBuffers][kBufferBytes];
  std::vector<uint8_t> shared;
};

uint32_t random_word(Random& random) {
  constexpr float kSpecial[] = {0.0f,
                                -0.0f,
                                1.0f,
                                -1.0f,
                                0.5f,
                                1e-40f,
                                3e38f,
                                std::numeric_limits<float>::infinity(),
                                std::numeric_limits<float>::quiet_NaN(),
                                2147483648.0f};
  switch (random.below(8)) {
    case 0:
    case 1:
    case 2:
      return random.below(16);
    case 3:
      return std::bit_cast<uint32_t>(kSpecial[random.below(std::size(kSpecial))]);
    case 4:
      return static_cast<uint32_t>(random.next());
    default:
      return std::bit_cast<uint32_t>(static_cast<float>(random.below(4096)) / 256 - 4);
  }
}

template <typename T>
void fill(T& object, Random& random) {
  auto* bytes = reinterpret_cast<uint8_t*>(&object);
  for (size_t at = 0; at + 4 <= sizeof(T); at += 4) {
    const uint32_t word = random_word(random);
    std::memcpy(bytes + at, &word, 4);
  }
}

void initialise(Memory& m, const Prepared& prepared, uint64_t seed) {
  Random random(seed);
  fill(m.table.push_constants, random);
  fill(m.wave, random);
  fill(m.buffers, random);
  const bool is_fragment = prepared.kernel.kind == ir::KernelKind::kFragment;  // all lanes run there, covered or not
  m.wave.mask = is_fragment || random.one_in(2) ? 0xffff : static_cast<uint32_t>(random.next() & 0xffff) | 1;
  m.wave.coverage = static_cast<uint32_t>(random.next()) & m.wave.mask;
  m.shared.assign(prepared.shared_bytes + 16, 0);
  for (uint32_t i = 0; i < Table::kBuffers; ++i) {
    // Some end early, in the middle of a word or vector.
    m.table.buffers[i] = {reinterpret_cast<uint64_t>(m.buffers[i]), kBufferBytes - (i % 4 == 0 ? i % 29 : 0), 0};
  }
  m.table.buffers[MemoryStage::kShared] = {reinterpret_cast<uint64_t>(m.shared.data()), prepared.shared_bytes, 0};
  for (uint32_t i = 0; i < 2; ++i) {
    const uint64_t address = reinterpret_cast<uint64_t>(m.buffers[8 * (i + 1)]),
                   other = reinterpret_cast<uint64_t>(m.buffers[8 * (2 - i)]);
    m.table.ranges[i] = {address, kBufferBytes, 0};
    std::memcpy(m.table.push_constants + 8 * i, &address, 8);
    std::memcpy(m.buffers[8 * (i + 1)] + 16, &other, 8);
  }
}

// ---- reading a module's head ----------------------------------------------------------------------------------------------

constexpr uint32_t kOpEntryPoint = 15, kMagic = 0x07230203;

bool stage_of(uint32_t model, VkShaderStageFlagBits& stage) {
  switch (model) {
    case 0:
      stage = VK_SHADER_STAGE_VERTEX_BIT;
      return true;
    case 4:
      stage = VK_SHADER_STAGE_FRAGMENT_BIT;
      return true;
    case 5:
      stage = VK_SHADER_STAGE_COMPUTE_BIT;
      return true;
    default:
      return false;
  }
}

ir::KernelKind kind_of(VkShaderStageFlagBits stage) {
  if (stage == VK_SHADER_STAGE_VERTEX_BIT) return ir::KernelKind::kVertex;
  return stage == VK_SHADER_STAGE_FRAGMENT_BIT ? ir::KernelKind::kFragment : ir::KernelKind::kCompute;
}

// ---- running --------------------------------------------------------------------------------------------------------------

struct Difference {
  const char* where = nullptr;
  size_t byte = 0;
};

Difference first_difference(const Memory& a, const Memory& b) {
  const auto find = [](const void* x, const void* y, size_t size) {
    const auto *p = static_cast<const uint8_t*>(x), *q = static_cast<const uint8_t*>(y);
    size_t i = 0;
    while (i < size && p[i] == q[i]) ++i;
    return i;
  };
  if (const size_t i = find(&a.wave, &b.wave, sizeof a.wave); i < sizeof a.wave) return {"outputs", i};
  if (const size_t i = find(a.buffers, b.buffers, sizeof a.buffers); i < sizeof a.buffers) return {"buffers", i};
  if (const size_t i = find(a.shared.data(), b.shared.data(), a.shared.size()); i < a.shared.size()) return {"shared memory", i};
  return {};
}

// A child's way to say that it has compiled its shader and runs it from now on; -1 elsewhere.
int running_pipe = -1;
constexpr char kRunning = 0x7f;

void note_running() {
  if (running_pipe >= 0) (void)!write(running_pipe, &kRunning, 1);
}

class Code {
 public:
  Code(const jit::Api& api, const ir::Kernel& kernel, jit::Isa isa) : api_(api), code(api.compile(kernel, {.isa = isa})) {}
  ~Code() {
    if (code.owner) api_.release(code.owner);
  }
  Code(const Code&) = delete;
  Code& operator=(const Code&) = delete;

 private:
  const jit::Api& api_;

 public:
  jit::Code code;
};

}  // namespace

std::vector<EntryPoint> entry_points(std::span<const uint32_t> words) {
  std::vector<EntryPoint> out;
  if (words.size() < 5 || words[0] != kMagic) return out;
  for (size_t at = 5; at < words.size() && words[at] >> 16 != 0; at += words[at] >> 16) {
    const size_t count = words[at] >> 16;
    if ((words[at] & 0xffff) != kOpEntryPoint || count < 4 || at + count > words.size()) continue;
    VkShaderStageFlagBits stage;
    if (!stage_of(words[at + 1], stage)) continue;
    const auto* text = reinterpret_cast<const char*>(&words[at + 3]);
    out.push_back({std::string(text, strnlen(text, 4 * (count - 3))), stage});
  }
  return out;
}

Prepared prepare(std::span<const uint32_t> words, const EntryPoint& entry) {
  Prepared out{.outcome = {Outcome::Kind::kAgreed, ""}};
  const auto module = spirv::parse({.words = words, .entry_point = entry.name, .stage = entry.stage});
  if (!module) {
    out.outcome = {Outcome::Kind::kRefused, module.error().text};
    return out;
  }
  out.shared_bytes = spirv::info(**module).shared_memory_bytes;
  out.kernel.name = "fuzz";
  out.kernel.kind = kind_of(entry.stage);
  out.kernel.wave_stride_bytes = sizeof(WaveRecord);
  ir::Builder b(out.kernel);
  MemoryStage stage;
  const auto translation = spirv::translate(**module, b, stage);
  if (!translation || stage.overflowed()) {
    out.outcome = {Outcome::Kind::kRefused,
                   translation ? "asks for more memory than the comparison has" : translation.error().text};
    return out;
  }
  stage.finish(b, *translation);
  if (const std::string fault = ir::verify(out.kernel); !fault.empty()) {
    out.outcome = {Outcome::Kind::kFailed, "translation is not well formed: " + fault};
    return out;
  }
  passes::optimize(out.kernel, passes::Form::kMachine);
  if (const std::string fault = ir::verify(out.kernel); !fault.empty()) {
    out.outcome = {Outcome::Kind::kFailed, "optimised kernel is not well formed: " + fault};
  }
  return out;
}

Outcome compare(const Prepared& prepared, uint64_t seed, uint32_t rounds) {
  std::string error;
  const jit::Api* api = jit::api(&error);
  if (!api) return {Outcome::Kind::kFailed, error};
  const eval::Program oracle(prepared.kernel, eval::Mode::kF32);
  const auto memory = std::make_unique<Memory>(), initial = std::make_unique<Memory>(), expected = std::make_unique<Memory>();
  const PrimRecord prim{nullptr, 0, 1};
  // What a wave keeps across barriers; the evaluator has its own.
  const size_t frame_bytes = std::max<size_t>(ir::wave_frame(prepared.kernel).bytes, ir::WaveFrame::kAlignmentBytes);
  const std::unique_ptr<void, decltype(&std::free)> frame(std::aligned_alloc(ir::WaveFrame::kAlignmentBytes, frame_bytes),
                                                          &std::free);
  ThreadContext thread{};
  thread.wave_frames = static_cast<uint8_t*>(frame.get());
  // All runs work on `memory`, because the table holds its addresses.
  const auto reset = [&](uint32_t round) { initialise(*memory, prepared, seed + round); };
  std::vector<std::unique_ptr<Code>> codes;
  for (jit::Isa isa : {jit::Isa::kSse42, jit::Isa::kAvx2, jit::Isa::kAvx512}) {
    if (!jit::isa_supported(isa)) continue;
    codes.push_back(std::make_unique<Code>(*api, prepared.kernel, isa));
    if (!codes.back()->code.error.empty())
      return {Outcome::Kind::kFailed, std::string(jit::isa_name(isa)) + ": " + codes.back()->code.error};
  }
  note_running();
  for (uint32_t round = 0; round < rounds; ++round) {
    reset(round);
    oracle.run(&memory->table, &thread, &prim, 1, &memory->wave);
    *expected = *memory;
    for (size_t i = 0; i < codes.size(); ++i) {
      reset(round);
      const KernelHandle handle{codes[i]->code.fn, nullptr};
      handle(&memory->table, &thread, &prim, 1, &memory->wave);
      if (const Difference d = first_difference(*expected, *memory); d.where) {
        return {Outcome::Kind::kDiffered, "instruction set " + std::to_string(i) + ", round " + std::to_string(round) +
                                              ": first in " + d.where + ", byte " + std::to_string(d.byte)};
      }
    }
  }
  return {Outcome::Kind::kAgreed, ""};
}

Outcome with_limits(uint32_t seconds, Outcome (*body)(void* argument), void* argument) {
  int ends[2];
  if (pipe(ends) != 0) return {Outcome::Kind::kFailed, "no pipe"};
  const pid_t child = fork();
  if (child == 0) {
    running_pipe = ends[1];
    const rlimit limit{seconds, seconds + 1};
    setrlimit(RLIMIT_CPU, &limit);
    const Outcome outcome = body(argument);
    std::string message(1, static_cast<char>(outcome.kind));
    message += outcome.text.substr(0, 2000);
    (void)!write(ends[1], message.data(), message.size());
    _exit(0);
  }
  close(ends[1]);
  std::string message;
  char part[512];
  for (ssize_t n; (n = read(ends[0], part, sizeof part)) > 0;) message.append(part, static_cast<size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  const bool was_running = message.starts_with(kRunning);
  if (was_running) message.erase(0, 1);
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) {
    return {was_running ? Outcome::Kind::kTooLong : Outcome::Kind::kFailed, "takes more than its processor time"};
  }
  if (WIFSIGNALED(status)) return {Outcome::Kind::kFailed, "signal " + std::to_string(WTERMSIG(status))};
  if (message.empty()) return {Outcome::Kind::kFailed, "ended with status " + std::to_string(WEXITSTATUS(status))};
  return {static_cast<Outcome::Kind>(message[0]), message.substr(1)};
}

}  // namespace pineda::fuzz
