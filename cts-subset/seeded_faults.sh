#!/usr/bin/env bash
# Seeds one fault after the other into a copy of the sources and asks the conformance cases: each must fail at least one.
# usage: cts-subset/seeded_faults.sh BUILD_DIR OUT.md      (BUILD_DIR holds pineda_cts)
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cts="$(cd "$1" && pwd)/pineda_cts"
out="$2"
copy="$(mktemp -d)"
trap 'rm -rf "$copy"' EXIT
export PINEDA_CACHE=off

# name | files | the code | what stands there instead | cases to ask
faults=(
  'coverage: the top edge and the bottom edge change places|raster/coverage.cpp raster/edge_list.h|_mm_cmpgt_epi32(b, zero))\n(a == 0 && b > 0)|_mm_cmplt_epi32(b, zero))\n(a == 0 && b < 0)|rasterization*'
  'samples: one of four lies 1/16 px further left|base/sample_locations.h|{{6, 2}, {14, 6}|{{6, 2}, {13, 6}|pipeline.multisample*'
  'blend factor: ONE_MINUS_SRC_ALPHA is SRC_ALPHA|compiler/kernels/blend.cpp|return one_minus(source_[kAlpha])|return source_[kAlpha]|pipeline.blend*'
  'rounding: the layer of an array is rounded down|compiler/kernels/sample_filter.cpp|b_.fround_even(request_.coord[axes_])|b_.ffloor(request_.coord[axes_])|texture*'
  'wrap mode: mirrored coordinates turn at one half|compiler/kernels/sample_address.cpp|b.fmin(period, b.fsub(b.f32(2), period))|b.fmin(period, b.fsub(b.f32(1), period))|texture*'
  'barrier: left out below 128 invocations|compiler/spirv/other.cpp|if (invocations > kLanes) t.b.barrier|if (invocations >= 128) t.b.barrier|compute.shared*'
  'bounds: 64 bytes more than the buffer has|compiler/jit/emit_bounds.cpp|usub_sat, a.limit, b_.getInt32(a.size_bytes - 1)|uadd_sat, a.limit, b_.getInt32(64)|robustness*'
  'depth test: LESS_OR_EQUAL is LESS|compiler/kernels/depth.cpp|return less_equal(a, c)|return less(a, c)|pipeline.depth*'
  'stencil: INVERT keeps|compiler/kernels/depth.cpp|return wrap(b.not_(old))|return wrap(old)|pipeline.stencil*'
  'subgroups: exclusive scans are inclusive|compiler/spirv/subgroup.cpp|scan = Scan::kExclusive|scan = Scan::kInclusive|subgroups*'
)

git clone -q --shared "$root" "$copy/pineda"
cd "$copy/pineda"
cmake --preset release >/dev/null
ninja -C build vk_pineda pineda_jit >/dev/null
printf '# Faults seeded on purpose, and what finds them\n\nWritten by `./run faults`.\n\n' >"$out"
printf '| fault | where | cases that fail | the first |\n|---|---|---|---|\n' >>"$out"
missed=0
for fault in "${faults[@]}"; do
  IFS='|' read -r name files from to filter <<<"$fault"
  mapfile -t old < <(printf '%b\n' "$from")
  mapfile -t new < <(printf '%b\n' "$to")
  read -ra list <<<"$files"
  for i in "${!list[@]}"; do
    FROM="${old[i]}" TO="${new[i]}" perl -pi -e 's/\Q$ENV{FROM}\E/$ENV{TO}/' "${list[i]}"
  done
  git diff --quiet && { echo "$name: the code is not there any more" >&2; missed=1; continue; }
  ninja -C build vk_pineda pineda_jit >/dev/null
  result="$("$cts" --driver "faulty=$PWD/build/pineda_icd.json" --gtest_filter="$filter" 2>/dev/null || true)"
  failed="$(grep -c '^FAIL ' <<<"$result" || true)"
  first="$(grep -m1 '^FAIL ' <<<"$result" | cut -d' ' -f2 | tr -d ':' || true)"
  ((failed)) || missed=1
  printf '| %s | %s | %s | `%s` |\n' "$name" "${files// /, }" "$failed" "$first" | tee -a "$out"
  git checkout -q .
done
exit $missed
