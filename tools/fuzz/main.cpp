// pineda_fuzz: random kernels, mutated SPIR-V and whole corpora, without a device. `./run fuzz` and `./run corpus` start it.
//
// pineda_fuzz kernels [--seconds N] [--count N] [--seed S]         random IR: machine code of every ISA against the evaluator
// pineda_fuzz spirv   [--seconds N] [--count N] [--seed S] FILE... every prefix of each module, then mutants of them all
// pineda_fuzz scale   [--count N] [--passes]                       compile times at N/4, N/2 and N instructions of each shape
// pineda_fuzz corpus  [--rounds N] [--seed S] [--all] FILE...      each module on every ISA against the evaluator
// pineda_fuzz bounds                                               what the bounds checks of the benchmark's kernels cost
//
// Each prints what it counted and gives status 1 when something differed or failed.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "compiler/eval/eval.h"
#include "compiler/ir/random_kernel.h"
#include "compiler/jit/jit.h"
#include "compiler/passes/passes.h"
#include "tools/fuzz/bounds.h"
#include "tools/fuzz/comparison.h"
#include "tools/fuzz/mutate.h"
#include "tools/fuzz/shapes.h"

namespace pineda::fuzz {
namespace {

struct Settings {
  double seconds = 0;  // 0: as long as `count` says
  uint64_t count = 0;  // 0: as long as `seconds` says
  uint64_t seed = 1;
  uint32_t rounds = 2;
  bool all = false;
  std::vector<std::string> files;
};

// Ends a run after a count or a time, whichever comes first, and says now and then how far it is.
class Progress {
 public:
  explicit Progress(const Settings& s) : settings_(s) {}
  bool next() {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const bool done =
        (settings_.count != 0 && count_ >= settings_.count) || (settings_.seconds > 0 && seconds >= settings_.seconds);
    if (done) return false;
    if (count_ != 0 && count_ % 1000 == 0)
      std::fprintf(stderr, "%llu after %.0f s\n", static_cast<unsigned long long>(count_), seconds);
    ++count_;
    return true;
  }
  uint64_t count() const { return count_; }

 private:
  const Settings& settings_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  uint64_t count_ = 0;
};

// Folders stand for the modules in them.
std::vector<std::string> expanded(const std::vector<std::string>& paths) {
  std::vector<std::string> out;
  for (const std::string& path : paths) {
    if (!std::filesystem::is_directory(path)) {
      out.push_back(path);
      continue;
    }
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
      if (entry.path().extension() == ".spv") out.push_back(entry.path());
    }
  }
  std::ranges::sort(out);
  return out;
}

std::vector<uint32_t> read_words(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  std::vector<uint32_t> words(bytes.size() / 4);
  std::copy_n(bytes.data(), words.size() * 4, reinterpret_cast<char*>(words.data()));
  return words;
}

// ---- random kernels -------------------------------------------------------------------------------------------------------

// Empty, or what is wrong with the kernel of this seed.
std::string check_kernel(const jit::Api& api, uint64_t seed) {
  Random random(seed ^ 0x5851F42D4C957F2Dull);
  const bool transcendentals = random.one_in(6);
  ir::RandomKernel program(seed, {.statements = 16 + random.below(48),
                                  .other_widths = !transcendentals && !random.one_in(4),
                                  .transcendentals = transcendentals,
                                  .atomics = !random.one_in(3),
                                  .barriers = random.one_in(3)});
  ir::Kernel kernel = program.kernel();
  if (transcendentals || !random.one_in(4)) passes::optimize(kernel, passes::Form::kMachine);
  const auto expected = program.run([&](auto... args) { eval::run(kernel, eval::Mode::kF32, args...); });
  for (jit::Isa isa : {jit::Isa::kSse42, jit::Isa::kAvx2, jit::Isa::kAvx512}) {
    if (!jit::isa_supported(isa)) continue;
    const jit::Code code = api.compile(kernel, {.isa = isa});
    if (!code.error.empty()) return std::string(jit::isa_name(isa)) + ": " + code.error;
    const KernelHandle handle{code.fn, nullptr};
    const auto got = program.run([&](auto... args) { handle(args...); });
    api.release(code.owner);
    if (got != expected) return std::string(jit::isa_name(isa)) + " differs from the evaluator";
  }
  return "";
}

struct KernelBatch {
  const jit::Api* api;
  uint64_t first, count;
};

Outcome check_batch(void* argument) {
  const KernelBatch& batch = *static_cast<const KernelBatch*>(argument);
  for (uint64_t i = 0; i < batch.count; ++i) {
    const std::string fault = check_kernel(*batch.api, batch.first + i);
    if (!fault.empty()) return {Outcome::Kind::kDiffered, fault};
  }
  return {Outcome::Kind::kAgreed, ""};
}

// A batch shares a process, and its kernels have one each when something is wrong with it. Gives how many are wrong.
uint64_t check_batch_in_child(KernelBatch batch) {
  constexpr uint32_t kSecondsEach = 20;
  const Outcome outcome = with_limits(kSecondsEach * 2, check_batch, &batch);
  if (outcome.kind == Outcome::Kind::kAgreed) return 0;
  uint64_t wrong = 0;
  for (uint64_t i = 0; i < batch.count; ++i) {
    KernelBatch one{batch.api, batch.first + i, 1};
    const Outcome alone = with_limits(kSecondsEach, check_batch, &one);
    if (alone.kind == Outcome::Kind::kAgreed) continue;
    ++wrong;
    std::printf("seed %llu: %s\n", static_cast<unsigned long long>(one.first), alone.text.c_str());
    std::fflush(stdout);
  }
  return wrong;
}

int kernels(const Settings& settings) {
  std::string error;
  const jit::Api* api = jit::api(&error);
  if (!api) {
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  constexpr uint64_t kBatch = 50;
  uint64_t wrong = 0;
  KernelBatch batch{api, settings.seed, 0};
  Progress progress(settings);
  for (bool more = true; more;) {
    more = progress.next();
    batch.count += more;
    if (batch.count < (more ? kBatch : 1)) continue;
    wrong += check_batch_in_child(batch);
    batch = {api, batch.first + batch.count, 0};
  }
  std::printf("%llu random kernels from seed %llu: %llu wrong\n", static_cast<unsigned long long>(progress.count()),
              static_cast<unsigned long long>(settings.seed), static_cast<unsigned long long>(wrong));
  return wrong != 0;
}

// ---- mutated modules ------------------------------------------------------------------------------------------------------

struct Seed {
  std::vector<uint32_t> words;
  EntryPoint entry;
};

std::vector<Seed> read_seeds(const std::vector<std::string>& files) {
  std::vector<Seed> out;
  for (const std::string& file : files) {
    std::vector<uint32_t> words = read_words(file);
    const std::vector<EntryPoint> entries = entry_points(words);
    if (!entries.empty()) out.push_back({std::move(words), entries.front()});
  }
  return out;
}

int spirv_mutants(const Settings& settings) {
  const std::vector<Seed> seeds = read_seeds(settings.files);
  if (seeds.empty()) {
    std::fprintf(stderr, "no module among the files\n");
    return 1;
  }
  uint64_t prefixes = 0, accepted = 0, wrong = 0;
  const auto check = [&](std::span<const uint32_t> words, const EntryPoint& entry, const std::string& what) {
    const Prepared prepared = prepare(words, entry);
    accepted += prepared.outcome.kind == Outcome::Kind::kAgreed;
    if (prepared.outcome.kind != Outcome::Kind::kFailed) return;
    ++wrong;
    std::printf("%s: %s\n", what.c_str(), prepared.outcome.text.c_str());
  };
  for (const Seed& seed : seeds) {
    for (size_t n = 0; n < seed.words.size(); ++n, ++prefixes) {
      // A buffer of its own, so that a sanitizer sees a read behind it.
      const std::vector<uint32_t> prefix(seed.words.begin(), seed.words.begin() + static_cast<ptrdiff_t>(n));
      check(prefix, seed.entry, "prefix of " + std::to_string(n) + " words");
    }
  }
  accepted = 0;
  Progress progress(settings);
  while (progress.next()) {
    Random random(settings.seed * 0x9E3779B97F4A7C15ull + progress.count());
    const Seed& seed = seeds[random.below(seeds.size())];
    check(mutate(seed.words, random), seed.entry,
          "seed " + std::to_string(settings.seed) + ", mutant " + std::to_string(progress.count()));
  }
  std::printf("%zu modules: %llu prefixes; %llu mutants from seed %llu, of which %llu were accepted; %llu wrong\n", seeds.size(),
              static_cast<unsigned long long>(prefixes), static_cast<unsigned long long>(progress.count()),
              static_cast<unsigned long long>(settings.seed), static_cast<unsigned long long>(accepted),
              static_cast<unsigned long long>(wrong));
  return wrong != 0;
}

// ---- compile time ---------------------------------------------------------------------------------------------------------

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Times {
  double passes = 0, back_end = 0;  // seconds of processor time; the first is the translation's, too
  std::string error;
};

Times compile_times(const jit::Api* api, const Shape& shape, uint32_t instructions) {
  const std::vector<uint32_t> words = shape.make(instructions);
  Times out;
  const double start = processor_seconds();
  const Prepared prepared = prepare(words, {"main", VK_SHADER_STAGE_COMPUTE_BIT});
  const double middle = processor_seconds();
  out.passes = middle - start;
  out.error = prepared.outcome.text;
  if (!api || !out.error.empty()) return out;
  const jit::Code code = api->compile(prepared.kernel, {.isa = jit::select_isa(&out.error)});
  out.back_end = processor_seconds() - middle;
  out.error = code.error;
  if (code.owner) api->release(code.owner);
  return out;
}

// Three sizes of each shape. Four times the size may take at most this many times as long: 4 is linear, 16 quadratic, and this
// the middle. What linear work takes above 4 is caches: the larger kernel no longer fits where the smaller one did.
constexpr double kMaxGrowth = 10;
// Processor time still varies with what else uses the caches, upwards only, so the least of this many is what counts; one more is
// taken only while the growth is too large.
constexpr uint32_t kTries = 4;

int scale(const Settings& settings) {
  std::string error;
  const jit::Api* api = settings.all ? nullptr : jit::api(&error);
  if (!error.empty()) return std::fprintf(stderr, "%s\n", error.c_str()), 1;
  const auto largest = static_cast<uint32_t>(settings.count != 0 ? settings.count : 100000);
  std::printf("%-14s %12s %20s %20s\n", "shape", "instructions", "translate, passes ms", "back end ms");
  uint32_t wrong = 0;
  for (const Shape& shape : shapes()) {
    std::map<uint32_t, double> least;  // seconds, by size
    const auto measure = [&](uint32_t n) {
      const Times times = compile_times(api, shape, n);
      std::printf("%-14s %12u %20.1f %20.1f %s\n", shape.name, n, 1e3 * times.passes, 1e3 * times.back_end, times.error.c_str());
      std::fflush(stdout);
      wrong += !times.error.empty();
      const double sum = times.passes + times.back_end;
      least[n] = least.contains(n) ? std::min(least[n], sum) : sum;
    };
    const auto growth = [&] { return least[largest] / least[largest / 4]; };
    for (uint32_t n = largest / 4; n <= largest; n *= 2) measure(n);
    for (uint32_t i = 0; i < 2; ++i) measure(largest / 4);  // short, so noise matters most here
    for (uint32_t i = 1; i < kTries && growth() > kMaxGrowth; ++i) measure(largest);
    const bool too_long = growth() > kMaxGrowth;
    std::printf("%s: %.1f times as long for 4 times the size%s\n", shape.name, growth(), too_long ? ": too long" : "");
    wrong += too_long;
  }
  return wrong != 0;
}

// ---- corpora --------------------------------------------------------------------------------------------------------------

// A refusal without the parts that differ from shader to shader: ids, word numbers, literals.
std::string class_of(const std::string& text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '(' && text.compare(i, 6, "(word ") == 0) {
      i = std::min(text.find(')', i), text.size() - 1);
      if (!out.empty() && out.back() == ' ') out.pop_back();
      continue;
    }
    const bool starts_id = text[i] == '%';
    out += text[i];
    while (starts_id && i + 1 < text.size() && std::isdigit(static_cast<unsigned char>(text[i + 1]))) ++i;
  }
  return out;
}

struct Job {
  const std::vector<uint32_t>* words;
  EntryPoint entry;
  const Settings* settings;
};

Outcome run_job(void* argument) {
  const Job& job = *static_cast<const Job*>(argument);
  const Prepared prepared = prepare(*job.words, job.entry);
  return prepared.outcome.kind == Outcome::Kind::kAgreed ? compare(prepared, job.settings->seed, job.settings->rounds)
                                                         : prepared.outcome;
}

struct CorpusCounts {
  uint64_t agreed = 0, too_long = 0, refused = 0, wrong = 0;
  void add(Outcome::Kind kind) {
    uint64_t& count = kind == Outcome::Kind::kAgreed    ? agreed
                      : kind == Outcome::Kind::kTooLong ? too_long
                      : kind == Outcome::Kind::kRefused ? refused
                                                        : wrong;
    ++count;
  }
  void print(const std::string& source) const {
    std::printf("| %s | %llu | %llu | %llu | %llu |\n", source.c_str(), static_cast<unsigned long long>(agreed),
                static_cast<unsigned long long>(too_long), static_cast<unsigned long long>(refused),
                static_cast<unsigned long long>(wrong));
  }
};

// collect.py has a folder for each.
std::string source_of(const std::string& file) { return std::filesystem::path(file).parent_path().filename(); }

int corpus(const Settings& settings) {
  constexpr uint32_t kSecondsEach = 20;
  std::string error;
  if (!jit::api(&error)) {  // opened once, here: the children inherit it
    std::fprintf(stderr, "%s\n", error.c_str());
    return 1;
  }
  CorpusCounts total;
  std::map<std::string, CorpusCounts> by_source;
  std::map<std::string, std::pair<uint64_t, std::string>> reasons;
  for (const std::string& file : settings.files) {
    const std::vector<uint32_t> words = read_words(file);
    for (const EntryPoint& entry : entry_points(words)) {
      Job job{&words, entry, &settings};
      const Outcome outcome = with_limits(kSecondsEach, run_job, &job);
      total.add(outcome.kind);
      by_source[source_of(file)].add(outcome.kind);
      if (outcome.kind == Outcome::Kind::kRefused) {
        auto& [count, example] = reasons[class_of(outcome.text)];
        ++count;
        example = std::filesystem::path(file).filename();
      } else if (outcome.kind != Outcome::Kind::kAgreed && outcome.kind != Outcome::Kind::kTooLong) {
        std::printf("%s: %s\n", file.c_str(), outcome.text.c_str());
      }
      if (settings.all) std::printf("%s %s\n", file.c_str(), outcome.text.c_str());
    }
  }
  std::printf(
      "| source | agreed on every ISA | compiled, ran too long on random data | refused | wrong |\n|---|---|---|---|---|\n");
  for (const auto& [source, counts] : by_source) counts.print(source);
  total.print("all");
  if (!reasons.empty()) std::printf("\nRefused:\n\n");
  for (const auto& [reason, found] : reasons) {
    std::printf("- %llu: %s (such as %s)\n", static_cast<unsigned long long>(found.first), reason.c_str(), found.second.c_str());
  }
  return total.wrong != 0;
}

}  // namespace
}  // namespace pineda::fuzz

int main(int argc, char** argv) {
  using pineda::fuzz::Settings;
  CLI::App app("Random and real shaders against the evaluator; no device is needed");
  app.require_subcommand(1);
  Settings settings;
  const auto add = [&](const char* name, const char* what, bool files) {
    CLI::App* verb = app.add_subcommand(name, what);
    verb->add_option("--seconds", settings.seconds, "stop after this time");
    verb->add_option("--count", settings.count, "stop after this many");
    verb->add_option("--seed", settings.seed, "where the random sequence begins");
    verb->add_option("--rounds", settings.rounds, "random memories for each shader");
    if (files) verb->add_option("files", settings.files, "SPIR-V modules, or folders of them")->required();
    return verb;
  };
  CLI::App* kernels = add("kernels", "random IR kernels", false);
  CLI::App* spirv = add("spirv", "truncated and mutated SPIR-V", true);
  CLI::App* scale = add("scale", "compile time against size", false);
  scale->add_flag("--passes", settings.all, "without the back end");
  CLI::App* corpus = add("corpus", "whole modules", true);
  CLI::App* bounds = add("bounds", "what bounds checks cost", false);
  corpus->add_flag("--all", settings.all, "name each module");
  CLI11_PARSE(app, argc, argv);
  if (settings.count == 0 && settings.seconds == 0) settings.seconds = 60;
  settings.files = pineda::fuzz::expanded(settings.files);
  if (*kernels) return pineda::fuzz::kernels(settings);
  if (*scale) return pineda::fuzz::scale(settings);
  if (*bounds) return pineda::fuzz::measure_bounds();
  if (*spirv) return pineda::fuzz::spirv_mutants(settings);
  return corpus->parsed() ? pineda::fuzz::corpus(settings) : 1;
}
