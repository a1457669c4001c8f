#!/usr/bin/env bash
# What README.md and ARCHITECTURE.md name exists: functions of the life of a draw in their files, paths, environment variables, pictures.
set -u
cd "$(dirname "${BASH_SOURCE[0]}")/.."
failures=0
fail() { echo "$1"; failures=$((failures + 1)); }

while IFS='|' read -r _ number function file _; do  # rows of the table: | 1 | `A::b` | path | ... |
  function=$(tr -d ' `' <<<"$function") file=$(tr -d ' ' <<<"$file")
  grep -qF "$function(" "$file" 2>/dev/null || fail "hop $number: no $function in $file"
done < <(grep -E '^\| [0-9]+ \|' ARCHITECTURE.md)

for path in $(grep -ohE '(base|compiler|raster|icd|tools|tests|docs)/[A-Za-z0-9_/.-]*[A-Za-z0-9_/]' README.md ARCHITECTURE.md | sort -u); do
  compgen -G "$path*" >/dev/null || fail "named but missing: $path"
done

for variable in $(grep -ohE 'PINEDA_[A-Z]+' README.md ARCHITECTURE.md | sort -u); do
  grep -rqF "$variable" base/config.cpp || fail "no such variable: $variable"
done

# PINEDA_DEBUG=help prints every variable that is read, and every flag that there is (their table is what is parsed).
for variable in $(grep -ohE '"PINEDA_[A-Z_]+"' base/config.cpp | tr -d '"' | sort -u); do
  grep -qE "^ +\"  $variable" base/config.cpp || fail "not in PINEDA_DEBUG=help: $variable"
done

[ "$failures" -eq 0 ] && echo "the documents name nothing that is not there"
exit "$((failures > 0))"
