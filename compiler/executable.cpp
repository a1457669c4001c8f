#include "compiler/executable.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <optional>

#include "base/config.h"
#include "base/deep_stack.h"
#include "base/float_environment.h"
#include "base/log.h"
#include "base/stop_word.h"
#include "compiler/build_id.h"
#include "compiler/code_image.h"
#include "compiler/code_store.h"
#include "compiler/disk_cache.h"
#include "compiler/eval/eval.h"
#include "compiler/ir/walk.h"
#include "compiler/ir/wave_frame.h"
#include "compiler/jit/jit.h"
#include "compiler/kernels/kernels.h"
#include "compiler/passes/passes.h"

namespace pineda::compiler {
namespace {

constexpr uint64_t kCodeFormat = 1;  // of blobs and images

std::atomic<uint64_t> checked_calls{0}, checked_bytes{0}, differing_bytes{0};

// ---- dumps ----------------------------------------------------------------------------------------------------------------

void dump(const std::string& name, const KernelHash& hash, const char* extension, const std::string& text) {
  const std::string file_name = name + "." + hash.text() + "." + extension;
  const std::string& directory = config().debug_dir;
  std::FILE* file = directory.empty() ? stderr : std::fopen((directory + "/" + file_name).c_str(), "w");
  if (!file) {
    report(Severity::kWarning, "cannot write " + directory + "/" + file_name);
    return;
  }
  if (file == stderr) std::fprintf(file, "==== %s\n", file_name.c_str());
  std::fwrite(text.data(), 1, text.size(), file);
  if (file != stderr) std::fclose(file);
}

class Stopwatch {
 public:
  double lap_ms() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - start_).count();
    start_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::string serialize_code(const Executable& executable, const std::string& image);

// ---- back ends ------------------------------------------------------------------------------------------------------------

// Machine code, released with its owner.
class MachineCode {
 public:
  MachineCode(const jit::Api& api, jit::Code code) : api_(&api), code_(std::move(code)) {}
  ~MachineCode() { api_->release(code_.owner); }
  MachineCode(const MachineCode&) = delete;
  MachineCode& operator=(const MachineCode&) = delete;
  const jit::Code& code() const { return code_; }

 private:
  const jit::Api* api_;
  jit::Code code_;
};

Result<const jit::Api*> find_back_end(jit::Isa* isa) {
  std::string error;
  const jit::Api* api = jit::api(&error);
  if (!api) return compile_error(error);
  *isa = jit::select_isa(&error);
  if (!error.empty()) return compile_error(error);
  return api;
}

Result<std::unique_ptr<MachineCode>> compile_machine_code(const ir::Kernel& kernel, const KernelHash& hash) {
  jit::Isa isa;
  const Result<const jit::Api*> found = find_back_end(&isa);
  if (!found) return std::unexpected(found.error());
  const jit::Api* api = *found;
  jit::Code code = api->compile(kernel, {.isa = isa, .want_llvm_ir = debug(kDebugLlvm), .want_assembly = debug(kDebugAsm)});
  if (!code.error.empty()) return compile_error(kernel.name + ": " + code.error);
  if (debug(kDebugLlvm)) dump(kernel.name, hash, "ll", code.llvm_ir);
  if (debug(kDebugAsm)) dump(kernel.name, hash, "s", code.assembly);
  return std::make_unique<MachineCode>(*api, std::move(code));
}

bool has_atomics(const ir::Kernel& kernel) {
  bool found = false;
  ir::for_each_inst(kernel, kernel.wave, [&](ir::Value v) { found |= kernel.at(v).op == ir::Op::kAtomic; });
  return found;
}

class BackedKernel final : public Executable {
 public:
  explicit BackedKernel(const KernelHash& hash) : hash_(hash) {}

  Result<void> finish() override {
    begun_.store(true, std::memory_order_relaxed);
    std::call_once(once_, [this] {
      const ScopedFloatEnvironment environment;  // constant folding
      Stopwatch stopwatch;
      with_deep_stack([this] { status_ = build(); });
      if (debug(kDebugTime) && status_) {
        std::fprintf(stderr, "pineda: %s: back end %.2f ms, %llu bytes of code\n", ir.name.c_str(), stopwatch.lap_ms(),
                     static_cast<unsigned long long>(machine_ ? machine_->code().size_bytes : 0));
      }
    });
    finished_.store(true, std::memory_order_release);
    return status_;
  }
  void finish_unless_begun() override {
    if (!begun_.exchange(true, std::memory_order_relaxed)) static_cast<void>(finish());
  }
  bool is_finished() const override { return finished_.load(std::memory_order_acquire); }
  CodeBlob blob() const override { return blob_; }

 private:
  Result<void> build() {
    const Mode mode = config().mode;
    if (mode != Mode::kJit) program_.emplace(ir, mode == Mode::kF64 ? eval::Mode::kF64 : eval::Mode::kF32);
    if (mode == Mode::kF32 || mode == Mode::kF64) {
      handle = {&eval::Program::invoke, &*program_};
      return {};
    }
    Result<std::unique_ptr<MachineCode>> code = compile_machine_code(ir, hash_);
    if (!code) return std::unexpected(code.error());
    machine_ = std::move(*code);
    if (key != KernelHash{} && !machine_->code().image.empty()) {
      blob_ = std::make_shared<const std::string>(serialize_code(*this, machine_->code().image));
      if (DiskCache* disk = disk_cache()) disk->insert(key, blob_);
    }
    // Other threads may change what an atomic sees between the two runs, so such kernels are not compared.
    const bool check = mode == Mode::kCheck && !has_atomics(ir);
    handle = check ? KernelHandle{&run_checked, this} : KernelHandle{machine_->code().fn, &stop_word()};
    return {};
  }

  // PINEDA_MODE=check: what the evaluator would store, then the machine code, then the difference.
  static void run_checked(const KernelHandle* handle, const void* draw, void* thread, const PrimRecord* prims,
                          uint32_t prim_count, const void* waves) {
    const auto& self = *static_cast<const BackedKernel*>(handle->self);
    const std::vector<eval::WrittenByte> expected = self.program_->dry_run(draw, thread, prims, prim_count, waves);
    const KernelHandle machine{self.machine_->code().fn, &stop_word()};
    machine(draw, thread, prims, prim_count, waves);
    uint64_t wrong = 0, first = 0;
    for (const eval::WrittenByte& byte : expected) {
      if (*reinterpret_cast<const uint8_t*>(byte.address) == byte.value) continue;
      if (wrong++ == 0) first = byte.address;
    }
    ++checked_calls;
    checked_bytes += expected.size();
    if (wrong == 0) return;
    differing_bytes += wrong;
    char text[160];
    std::snprintf(text, sizeof text, ": machine code and evaluator differ in %llu of %zu stored bytes, first at %#llx",
                  static_cast<unsigned long long>(wrong), expected.size(), static_cast<unsigned long long>(first));
    report(Severity::kError, self.ir.name + text);
  }

  const KernelHash hash_;
  std::once_flag once_;
  std::atomic<bool> begun_{false}, finished_{false};
  Result<void> status_;  // of build(); valid once `once_` has run
  std::optional<eval::Program> program_;
  std::unique_ptr<MachineCode> machine_;
  CodeBlob blob_;  // constant once finish() has returned
};

// ---- hashing --------------------------------------------------------------------------------------------------------------

class Hasher {
 public:
  void add(uint64_t word) { words_.push_back(word); }
  KernelHash result() const { return hash_words(words_); }

 private:
  std::vector<uint64_t> words_;
};

// ---- what is kept of a kernel -----------------------------------------------------------------------------------------------

struct BlobHeader {
  uint64_t frame_bytes = 0;
  uint64_t varying_count = 0;
};

// A header, the varyings of a fragment kernel, the image of its code.
std::string serialize_code(const Executable& executable, const std::string& image) {
  const BlobHeader header{executable.frame_bytes, executable.varyings.size()};
  std::string blob(reinterpret_cast<const char*>(&header), sizeof header);
  blob.append(reinterpret_cast<const char*>(executable.varyings.data()), executable.varyings.size() * sizeof(VaryingSlot));
  return blob + image;
}

// Code that some store had.
class StoredKernel final : public Executable {
 public:
  static std::shared_ptr<StoredKernel> load(const CodeBlob& blob) {
    auto kernel = std::make_shared<StoredKernel>();
    BlobHeader header;
    if (blob->size() < sizeof header) return nullptr;
    std::memcpy(&header, blob->data(), sizeof header);
    const size_t room = (blob->size() - sizeof header) / sizeof(VaryingSlot);
    if (header.varying_count > room || header.frame_bytes > kMaxImageBytes) return nullptr;
    kernel->frame_bytes = header.frame_bytes;
    kernel->varyings.resize(header.varying_count);
    const size_t varyings_bytes = header.varying_count * sizeof(VaryingSlot);
    if (varyings_bytes != 0) std::memcpy(kernel->varyings.data(), blob->data() + sizeof header, varyings_bytes);  // null if none
    const size_t image_at = sizeof header + varyings_bytes;
    kernel->code_ = MappedImage::map(std::string_view(*blob).substr(image_at));
    if (!kernel->code_) return nullptr;
    kernel->handle = {kernel->code_->entry(), &stop_word()};
    kernel->blob_ = blob;
    return kernel;
  }
  Result<void> finish() override { return {}; }
  void finish_unless_begun() override {}
  bool is_finished() const override { return true; }
  CodeBlob blob() const override { return blob_; }

 private:
  std::unique_ptr<MappedImage> code_;
  CodeBlob blob_;
};

}  // namespace

Result<void> back_end_available() {
  jit::Isa isa;
  const bool evaluates = config().mode == Mode::kF32 || config().mode == Mode::kF64;
  if (evaluates) return {};
  const Result<const jit::Api*> found = find_back_end(&isa);
  return found ? Result<void>() : std::unexpected(found.error());
}

KernelHash hash_kernel(const ir::Kernel& kernel) {
  Hasher hasher;
  hasher.add(static_cast<uint64_t>(kernel.kind) << 32 | kernel.wave_stride_bytes);
  hasher.add(kernel.full_waves);
  for (const ir::Inst& inst : kernel.insts) {
    hasher.add(static_cast<uint64_t>(inst.op) << 32 | static_cast<uint64_t>(inst.type) << 16 | inst.flags);
    hasher.add(static_cast<uint64_t>(inst.operand[0].id) << 32 | inst.operand[1].id);
    hasher.add(static_cast<uint64_t>(inst.operand[2].id) << 32 | inst.operand[3].id);
    hasher.add(inst.operand[4].id);
    hasher.add(inst.imm);
    if (ir::has_list(inst.op)) hasher.add(inst.list);
    for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) hasher.add(inst.region[r]);
  }
  const auto add_values = [&](const std::vector<ir::Value>& values) {
    hasher.add(values.size());
    for (const ir::Value v : values) hasher.add(v.id);
  };
  for (const ir::Region& region : kernel.regions) add_values(region.insts);
  for (const std::vector<ir::Value>& list : kernel.lists) add_values(list);
  return hasher.result();
}

KernelHash code_key(const KernelHash& kernel) {
  constexpr uint32_t kLooksAtKernels = kDebugIr | kDebugLlvm | kDebugAsm | kDebugPerf;
  static const KernelHash build = hash_bytes(build_id());
  static std::string isa_error;
  static const jit::Isa isa = jit::select_isa(&isa_error);
  if (config().mode != Mode::kJit || debug(static_cast<DebugFlag>(kLooksAtKernels)) || build_id().empty() || !isa_error.empty())
    return {};
  return hash_words(std::array{kCodeFormat, build.high, build.low, static_cast<uint64_t>(isa),
                               static_cast<uint64_t>(config().precision), kernel.high, kernel.low});
}

namespace {

// Null when nobody has it.
ExecutablePtr find_stored(const KernelHash& key, CodeStore* store) {
  if (key == KernelHash{}) return nullptr;
  for (CodeStore* place : {store, static_cast<CodeStore*>(disk_cache())}) {
    const CodeBlob blob = place ? place->find(key) : nullptr;
    if (!blob) continue;
    if (std::shared_ptr<StoredKernel> kernel = StoredKernel::load(blob)) return kernel;
  }
  return nullptr;
}

}  // namespace

Result<ExecutablePtr> make_executable(ir::Kernel kernel, const KernelHash& hash, CodeStore* store) {
  const KernelHash key = code_key(hash);
  if (ExecutablePtr stored = find_stored(key, store)) {
    stored->key = key;
    stored->ir.name = std::move(kernel.name);
    stored->ir.kind = kernel.kind;
    return stored;
  }
  Stopwatch stopwatch;
  std::string fault;
  with_deep_stack([&] {
    fault = ir::verify(kernel);
    const bool truth = config().mode == Mode::kF64;
    if (fault.empty()) passes::optimize(kernel, truth ? passes::Form::kTruth : passes::Form::kMachine, config().precision);
  });
  if (!fault.empty()) return compile_error(kernel.name + " is not well formed: " + fault);
  auto executable = std::make_shared<BackedKernel>(hash);
  if (kernel.kind == ir::KernelKind::kFragment) executable->varyings = kernels::compact_varyings(kernel);
  executable->frame_bytes = ir::wave_frame(kernel).bytes;
  executable->ir = std::move(kernel);
  executable->key = key;
  if (debug(kDebugTime)) {
    std::fprintf(stderr, "pineda: %s: %zu instructions, passes %.2f ms\n", executable->ir.name.c_str(),
                 executable->ir.insts.size(), stopwatch.lap_ms());
  }
  if (debug(kDebugIr)) dump(executable->ir.name, hash, "ir", ir::print(executable->ir));
  return executable;
}

CheckStatistics check_statistics() { return {checked_calls, checked_bytes, differing_bytes}; }

}  // namespace pineda::compiler
