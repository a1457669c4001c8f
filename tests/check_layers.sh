#!/usr/bin/env bash
# The layers of ARCHITECTURE.md, checked against every #include:  icd -> raster, compiler -> base;  LLVM only under compiler/jit;
# Vulkan handles and *CreateInfo only in icd (and in the clients: tools, tests).
set -u
cd "$(dirname "${BASH_SOURCE[0]}")/.."
failures=0

forbid() {  # forbid PATTERN REASON FILES...
  local pattern=$1 reason=$2
  shift 2
  local hits
  hits=$(grep -nE "$pattern" "$@" 2>/dev/null)
  if [ -n "$hits" ]; then
    printf '%s\n%s\n' "$reason:" "$hits"
    failures=$((failures + 1))
  fi
}

sources() { find "$@" -name '*.h' -o -name '*.cpp' -o -name '*.inc' | grep -vE '_test\.cpp$|/test_[a-z]+\.h$'; }

forbid '#include "(compiler|raster|icd|tools|tests)/' 'base includes another layer' $(sources base)
forbid '#include "(raster|icd|tools|tests)/' 'compiler includes another layer' $(sources compiler)
forbid '#include "(compiler|icd|tools|tests)/' 'raster includes another layer' $(sources raster)
forbid '#include "(tools|tests)/' 'icd includes a client' $(sources icd)
forbid '#include "(base|compiler|raster|icd)/' 'tools are clients of the loader, not of the driver' $(sources tools | grep -v '^tools/fuzz/')  # the fuzzer drives the compiler, without a device
forbid '#include [<"]llvm' 'LLVM outside compiler/jit' $(sources base compiler raster icd tools | grep -v '^compiler/jit/')
forbid 'Vk[A-Za-z0-9]*CreateInfo' 'CreateInfo structs outside icd' $(sources base compiler raster)

if [ "$failures" -ne 0 ]; then
  echo "$failures layer rule(s) broken"
  exit 1
fi
echo "layers hold"
