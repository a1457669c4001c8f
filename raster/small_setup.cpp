#include "raster/small_setup.h"

#include <immintrin.h>

#include <cstring>

namespace pineda::raster {
namespace {

#define PINEDA_ISA_CODE "raster/small_setup_impl.inc"
#include "raster/isa_copies.inc"

}  // namespace

SmallGatherFn small_gather_function(Isa isa) {
  return for_isa(isa, sse42::small_gather, avx2::small_gather, avx512::small_gather);
}

SmallSetupFn small_setup_function(Isa isa) { return for_isa(isa, sse42::small_setup, avx2::small_setup, avx512::small_setup); }

SmallRecordsFn small_records_function(Isa isa) {
  return for_isa(isa, sse42::small_records, avx2::small_records, avx512::small_records);
}

}  // namespace pineda::raster
