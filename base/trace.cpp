#include "base/trace.h"

#include <unistd.h>

#include <cinttypes>
#include <cstdio>
#include <ctime>
#include <memory>
#include <mutex>

#include "base/config.h"

namespace pineda {
namespace {

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

struct TraceFile {
  std::unique_ptr<std::FILE, Close> file;
  std::mutex mutex;

  TraceFile() {
    const std::string& path = config().trace_file;
    if (path.empty()) return;
    file.reset(std::fopen(path.c_str(), "we"));
    if (!file) {
      std::fprintf(stderr, "pineda: PINEDA_TRACE=%s is ignored: the file cannot be written\n", path.c_str());
      return;
    }
    std::fputs("[\n", file.get());
  }
};

TraceFile& trace_file() {
  static TraceFile file;
  return file;
}

}  // namespace

bool tracing() { return trace_file().file != nullptr; }

uint64_t now_ns() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<uint64_t>(t.tv_sec) * 1'000'000'000 + static_cast<uint64_t>(t.tv_nsec);
}

void trace_event(const char* name, uint64_t begin_ns, uint64_t end_ns) {
  TraceFile& trace = trace_file();
  if (!trace.file) return;
  const std::lock_guard lock(trace.mutex);
  std::fprintf(trace.file.get(),
               "{\"name\":\"%s\",\"ph\":\"X\",\"pid\":%d,\"tid\":%d,\"ts\":%" PRIu64 ".%03u,\"dur\":%" PRIu64 ".%03u},\n", name,
               static_cast<int>(getpid()), static_cast<int>(gettid()), begin_ns / 1000, static_cast<unsigned>(begin_ns % 1000),
               (end_ns - begin_ns) / 1000, static_cast<unsigned>((end_ns - begin_ns) % 1000));
  std::fflush(trace.file.get());
}

}  // namespace pineda
