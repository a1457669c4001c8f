#include "raster/small_group.h"

#include <immintrin.h>

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "raster/hi_z.h"

namespace pineda::raster {

void SmallBatches::set_all(const Batch& batch) {
  set(0, batch);
  for (int32_t(&lanes)[16] :
       {std::ref(vertices[0]), std::ref(vertices[1]), std::ref(wave_bytes), std::ref(viewport), std::ref(layer)})
    std::fill_n(lanes, 16, lanes[0]);
}

namespace {

#define PINEDA_ISA_CODE "raster/small_group_impl.inc"
#include "raster/isa_copies.inc"

}  // namespace

SmallGroupFn small_group_function(Isa isa) { return for_isa(isa, sse42::small_group, avx2::small_group, avx512::small_group); }

}  // namespace pineda::raster
