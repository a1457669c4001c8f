// A trace of what threads do when, in the Trace Event Format that chrome://tracing and Perfetto open: PINEDA_TRACE=FILE.
#pragma once

#include <cstdint>

namespace pineda {

bool tracing();

// CLOCK_MONOTONIC.
uint64_t now_ns();

// An event from begin to end on this thread; for a list that grows while the process runs, so the file has no closing bracket
// (the format allows that).
void trace_event(const char* name, uint64_t begin_ns, uint64_t end_ns);

}  // namespace pineda
