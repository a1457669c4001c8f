#!/usr/bin/env bash
# The driver's tests under the Khronos validation layer, through the loader:  validate_tests.sh BUILD [gtest arguments]
# Twice: as it is, and with synchronization validation. Exit status 1 when a test fails or the layer says anything.
set -u
build=$(cd "$1" && pwd)
shift
export VK_DRIVER_FILES=$build/pineda_icd.json VK_ICD_FILENAMES=$build/pineda_icd.json
export PINEDA_TEST_LOADER=1 VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# Left out: what looks at the driver's entry points and allocations, which the loader and the layer stand before; programs of their
# own; what forks or ends its process; and what breaks a rule of the specification on purpose, to see that nothing worse happens.
without='IcdEntry.*:IcdAllocation.*:IcdRegistry.*:IcdIdentity.*:IcdFaults.*:Clients.*:*BadInput*:*Golden*:IcdDiskCache.*'

status=0
for enables in '' VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT; do
  VK_LAYER_ENABLES=$enables "$build/pineda_api_tests" --gtest_filter="-$without" "$@" >"$log" 2>&1 || { status=1; grep 'FAILED' "$log"; }
  messages=$(grep -cE '^(Validation|UNASSIGNED|VUID)|Validation (Error|Warning)' "$log")
  echo "${enables:-validation}: $(sed -n 's/^\[  PASSED  \] //p' "$log") $messages messages"
  ((messages == 0)) || { status=1; grep -E '\[ RUN|Validation (Error|Warning)' "$log" | grep -B1 'Validation' | head -40; }
done
exit $status
