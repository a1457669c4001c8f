// Messages. Every one goes through report(), so there is one place to break on. icd installs a sink that forwards to
// VK_EXT_debug_utils.
#pragma once

#include <functional>
#include <string_view>

namespace pineda {

enum class Severity { kInfo, kWarning, kError };

// Errors and warnings are printed to stderr when PINEDA_DEBUG is set (info with its flag `api`); always given to the sink.
void report(Severity severity, std::string_view text);

using LogSink = std::function<void(Severity, std::string_view)>;
void set_log_sink(LogSink sink);  // empty: none

}  // namespace pineda
