#!/usr/bin/env bash
# The driver's tests under the Khronos validation layer, through the loader:  validate_tests.sh BUILD [FILTER]
# Each test in a process of its own, as the layer does not survive some of the modules that the driver must refuse. Prints what was
# said by message id, and the tests that were clean. Set VK_LAYER_ENABLES for synchronization validation. Exit status 1 when a test
# fails that passes without the layer.
set -u
build=$(cd "$1" && pwd)
filter=${2:-*}
export VK_DRIVER_FILES=$build/pineda_icd.json VK_ICD_FILENAMES=$build/pineda_icd.json
export PINEDA_TEST_LOADER=1 VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# Left out: what looks at the driver's entry points and allocations, which the loader and the layer stand before; what forks or ends
# its process; what runs programs; SPIR-V that is damaged on purpose.
without='IcdEntry.*:IcdAllocation.*:IcdRegistry.*:IcdIdentity*:IcdFaults*:Clients*:*BadInput*:*Golden*:IcdDiskCache.*:BitContract*'
without+=':IcdCompute.InvalidShaders*:IcdCompute.Damaged*:IcdPipelines.AFailedOne*:IcdVersion11.VersionIsTheSame*'

tests=0 clean=0 status=0
while read -r test; do
  tests=$((tests + 1))
  out=$(timeout 120 "$build/pineda_api_tests" --gtest_filter="$test" 2>&1)
  if [ $? != 0 ] && ! grep -q 'Validation Error' <<<"$out"; then
    echo "failed: $test"
    status=1
  fi
  messages=$(grep -oE 'Validation (Error|Warning): \[ [^ ]+' <<<"$out" | sed 's/.*\[ //' | sort -u)
  if [ -z "$messages" ]; then clean=$((clean + 1)); else sed "s|\$| $test|" <<<"$messages" >>"$log"; fi
done < <("$build/pineda_api_tests" --gtest_list_tests --gtest_filter="$filter:-$without" | awk '/^[^ ]/ {suite = $1} /^  / {print suite $1}')

echo "$clean of $tests tests without a message; tests by message:"
cut -d' ' -f1 "$log" | sort | uniq -c | sort -rn
exit $status
