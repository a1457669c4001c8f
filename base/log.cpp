#include "base/log.h"

#include <cstdio>
#include <cstdlib>
#include <mutex>

#include "base/config.h"

namespace pineda {
namespace {

std::mutex g_mutex;  // held while a message is delivered, so that messages of several threads do not interleave
LogSink g_sink;

}  // namespace

void report(Severity severity, std::string_view text) {
  static const bool kPrint = std::getenv("PINEDA_DEBUG") != nullptr;
  std::lock_guard lock(g_mutex);
  if (kPrint && (severity != Severity::kInfo || debug(kDebugApi))) {
    constexpr const char* kNames[] = {"info", "warning", "error"};
    std::fprintf(stderr, "pineda: %s: %.*s\n", kNames[static_cast<int>(severity)], static_cast<int>(text.size()), text.data());
  }
  if (g_sink) g_sink(severity, text);
}

void set_log_sink(LogSink sink) {
  std::lock_guard lock(g_mutex);
  g_sink = std::move(sink);
}

}  // namespace pineda
