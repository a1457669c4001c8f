// What the bounds checks of compute shaders cost.
#pragma once

namespace pineda::fuzz {

// Compiles each of the benchmark's compute kernels twice, as it is and without the limits of its accesses, runs both in turn on
// one thread over data that stay in cache, and prints the times. Status 1 when something fails.
int measure_bounds();

}  // namespace pineda::fuzz
