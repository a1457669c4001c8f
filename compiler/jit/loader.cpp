// Chooses the instruction set and opens the back end's library. The only file of this folder that is part of the driver itself.
#include <cpuid.h>
#include <dlfcn.h>
#include <unistd.h>

#include <climits>

#include "base/config.h"
#include "compiler/jit/jit.h"

namespace pineda::jit {
namespace {

struct CpuidLeaf {
  uint32_t eax = 0, ebx = 0, ecx = 0, edx = 0;
};

CpuidLeaf cpuid(uint32_t leaf, uint32_t subleaf = 0) {
  CpuidLeaf r;
  __get_cpuid_count(leaf, subleaf, &r.eax, &r.ebx, &r.ecx, &r.edx);  // leaves r zero when the leaf does not exist
  return r;
}

constexpr bool has_all(uint32_t word, uint32_t bits) { return (word & bits) == bits; }

// XCR0: the register state that the operating system saves on a context switch. A CPU feature whose registers are not saved
// must not be used (Intel SDM vol. 1, 14.3 and 15.2).
uint64_t saved_state() {
  uint32_t low, high;
  __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return low | static_cast<uint64_t>(high) << 32;
}

// Highest level of the x86-64 psABI (v2, v3, v4) that CPU and operating system run, 1 = the 2003 baseline.
int psabi_level() {
  const CpuidLeaf basic = cpuid(1), extended = cpuid(7), amd = cpuid(0x80000001);
  if (!has_all(basic.ecx, bit_SSE3 | bit_SSSE3 | bit_SSE4_1 | bit_SSE4_2 | bit_POPCNT | bit_CMPXCHG16B)) return 1;
  if (!has_all(basic.ecx, bit_OSXSAVE | bit_AVX | bit_FMA | bit_F16C | bit_MOVBE)) return 2;
  if (!has_all(extended.ebx, bit_AVX2 | bit_BMI | bit_BMI2) || !has_all(amd.ecx, bit_LZCNT)) return 2;
  constexpr uint64_t kYmmState = 0x6, kZmmState = 0xe6;  // XMM, YMM; and opmask, upper ZMM0-15, ZMM16-31
  if ((saved_state() & kYmmState) != kYmmState) return 2;
  if (!has_all(extended.ebx, bit_AVX512F | bit_AVX512BW | bit_AVX512CD | bit_AVX512DQ | bit_AVX512VL)) return 3;
  return (saved_state() & kZmmState) == kZmmState ? 4 : 3;
}

constexpr Isa kAllIsas[] = {Isa::kSse42, Isa::kAvx2, Isa::kAvx512};
constexpr int required_level(Isa isa) { return static_cast<int>(isa) + 2; }

// Directory of the file that contains this code, with a slash at the end.
std::string own_directory() {
  std::string path;
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&own_directory), &info) != 0 && info.dli_fname != nullptr) path = info.dli_fname;
  if (path.find('/') == std::string::npos) {  // the main program, found through PATH: the loader knows its bare name only
    char buffer[PATH_MAX];
    const ssize_t length = readlink("/proc/self/exe", buffer, sizeof buffer);
    if (length > 0) path.assign(buffer, static_cast<size_t>(length));
  }
  return path.substr(0, path.rfind('/') + 1);
}

struct Loaded {
  const Api* api = nullptr;
  std::string error;
};

Loaded open_plugin() {
  const std::string path = plugin_path();
  void* library = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);  // never closed: its code runs until the process ends
  if (library == nullptr) return {.error = std::string("cannot open the compiler back end: ") + dlerror()};
  const auto entry = reinterpret_cast<const Api* (*)()>(dlsym(library, "pineda_jit_api"));
  if (entry == nullptr) return {.error = path + " does not export pineda_jit_api"};
  const Api* api = entry();
  if (api->version != kApiVersion) return {.error = path + " belongs to another version of Pineda"};
  return {.api = api};
}

}  // namespace

std::string plugin_path() { return own_directory() + "libpineda_jit.so"; }

const Api* api(std::string* error) {
  static const Loaded loaded = open_plugin();
  if (loaded.api == nullptr && error != nullptr) *error = loaded.error;
  return loaded.api;
}

const char* isa_name(Isa isa) {
  switch (isa) {
    case Isa::kSse42:
      return "sse42";
    case Isa::kAvx2:
      return "avx2";
    case Isa::kAvx512:
      return "avx512";
  }
  return "?";
}

bool isa_supported(Isa isa) {
  static const int level = psabi_level();
  return level >= required_level(isa);
}

Isa select_isa(std::string* error) {
  const std::string& wanted = config().isa;
  Isa best = Isa::kSse42;
  bool known = wanted.empty();
  for (Isa isa : kAllIsas) {
    if (wanted.empty() ? isa_supported(isa) : wanted == isa_name(isa)) {
      best = isa;
      known = true;
    }
  }
  if (error != nullptr && !known) {
    *error = "PINEDA_ISA=" + wanted + " is not one of sse42, avx2, avx512";
  } else if (error != nullptr && !isa_supported(best)) {
    *error = wanted.empty() ? "this CPU is older than x86-64-v2 (SSE4.2, POPCNT), the least that Pineda runs on"
                            : "PINEDA_ISA=" + wanted + ": this CPU, or its operating system, does not support it";
  }
  return best;
}

}  // namespace pineda::jit
