#include "raster/small_setup.h"

#include <immintrin.h>

#include <cstring>

namespace pineda::raster {
namespace {

#define PINEDA_ISA_CODE "raster/small_setup_impl.inc"
#include "raster/isa_copies.inc"

}  // namespace

SmallGatherFn small_gather_function(Isa isa) {
  switch (isa) {
    case Isa::kAvx512:
      return avx512::small_gather;
    case Isa::kAvx2:
      return avx2::small_gather;
    case Isa::kSse42:
      return sse42::small_gather;
  }
  return sse42::small_gather;
}

SmallSetupFn small_setup_function(Isa isa) {
  switch (isa) {
    case Isa::kAvx512:
      return avx512::small_setup;
    case Isa::kAvx2:
      return avx2::small_setup;
    case Isa::kSse42:
      return sse42::small_setup;
  }
  return sse42::small_setup;
}

SmallRecordsFn small_records_function(Isa isa) {
  switch (isa) {
    case Isa::kAvx512:
      return avx512::small_records;
    case Isa::kAvx2:
      return avx2::small_records;
    case Isa::kSse42:
      return sse42::small_records;
  }
  return sse42::small_records;
}

}  // namespace pineda::raster
