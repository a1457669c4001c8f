// Room for deep recursion. The compiler recurses over nested control flow, which shaders may nest a thousand deep, and it runs on
// whatever thread the application calls from.
#pragma once

#include <functional>

namespace pineda {

// Calls `fn` here when this thread's stack has room enough, else on a thread of its own, which it waits for. Exceptions pass
// through.
void with_deep_stack(const std::function<void()>& fn);

}  // namespace pineda
