#!/usr/bin/env bash
# The Debian package: made, installed into an empty root, used from there, removed again without a trace.   check_package.sh BUILD
set -euo pipefail
build=$1
for program in cpack dpkg dpkg-deb dpkg-shlibdeps fakeroot; do
  command -v "$program" >/dev/null || { echo "skipped: $program is not installed"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

(cd "$build" && cpack -G DEB -B "$work/out" >"$work/cpack.log" 2>&1) || { cat "$work/cpack.log"; exit 1; }
deb=$(echo "$work"/out/*.deb)
root=$work/root
mkdir -p "$root"/var/lib/dpkg/{info,updates}
touch "$root/var/lib/dpkg/status" "$root/var/lib/dpkg/available"
run_dpkg() { fakeroot dpkg --root="$root" --log="$work/dpkg.log" --force-depends --force-script-chrootless "$@" >/dev/null; }

run_dpkg -i "$deb"
manifest=$(echo "$root"/usr/share/vulkan/icd.d/pineda_icd.*.json)
library=$(sed -n 's/.*"library_path": "\([^"]*\)".*/\1/p' "$manifest")
[ -f "$root$library" ] || { echo "the manifest names $library, which is not in the package"; exit 1; }
# The manifest is right for /; for this root its path is prefixed.
sed "s|$library|$root$library|" "$manifest" >"$work/icd.json"
installed=$(PINEDA_CACHE=off "$build/pineda" render triangle --driver "installed=$work/icd.json" --hash --out "$work/a.png")
built=$(PINEDA_CACHE=off "$build/pineda" render triangle --driver "built=$build/pineda_icd.json" --hash --out "$work/b.png")
cmp "$work/a.png" "$work/b.png" || { echo "installed: $installed"; echo "built: $built"; exit 1; }

run_dpkg -r pineda-vulkan-driver
left=$(find "$root/usr" -type f 2>/dev/null || true)
[ -z "$left" ] || { echo "left behind: $left"; exit 1; }
echo "made $(basename "$deb") ($(stat -c %s "$deb") bytes), installed, used, removed"
