// Independent pieces of work on several threads, for what happens rarely and takes milliseconds (compiling): threads are started
// for it and end with it, so that an idle driver has none.
#pragma once

#include <cstdint>
#include <functional>

namespace pineda {

// body(0) ... body(count - 1), in any order, on this thread and as many others as help; all are done when it returns. In the
// whole process no more of such threads run at once than PINEDA_THREADS (or the number of cores) less one, so calls may nest and
// meet. An exception of a piece reaches the caller, once all have ended. The threads have the float environment that kernels
// expect.
void parallel_for(uint32_t count, const std::function<void(uint32_t index)>& body);

}  // namespace pineda
