#!/usr/bin/env bash
# Programs that nobody here wrote, on the driver just built:  run_clients.sh BUILD OUT [client...]
# Writes OUT/clients.md and a picture of each into OUT/clients/. A client that is not installed is skipped and said so. Exit status 1
# when one that should work does not.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$(cd "$1" && pwd)
mkdir -p "$2/clients"
out=$(cd "$2" && pwd)
shift 2
work=$(mktemp -d)
pids=()
cleanup() {
  [ "$BASHPID" = "$$" ] || return  # not in a subshell
  ((${#pids[@]})) && kill "${pids[@]}" 2>/dev/null
  wait 2>/dev/null
  rm -rf "$work"
}
trap cleanup EXIT

export VK_DRIVER_FILES=$build/pineda_icd.json VK_ICD_FILENAMES=$build/pineda_icd.json PINEDA_DEBUG=api
export XDG_RUNTIME_DIR=$work
chmod 700 "$work"
lavapipe=$(ls /usr/share/vulkan/icd.d/lvp_icd*.json 2>/dev/null | head -1)
failures=0

have() { command -v "$1" >/dev/null; }
version() { dpkg-query -W -f='${Version}' "$1" 2>/dev/null; }

display_started=
start_display() {  # an X server of our own
  have Xvfb || return 1
  local number=$work/display
  Xvfb -displayfd 8 -screen 0 1024x768x24 8>"$number" 2>/dev/null &
  pids+=($!)
  for _ in $(seq 100); do [ "$(wc -l <"$number")" = 1 ] && break; sleep 0.1; done  # a whole line: it takes connections
  export DISPLAY=:$(cat "$number")
  display_started=1
}

# row CLIENT VERSION RESULT COMMAND: one line of the table. RESULT: works, fails, skipped (with a reason).
row() {
  printf '| %s | %s | %s | `%s` |\n' "$1" "$2" "$3" "$4" >>"$out/clients.md"
  printf '%-22s %s\n' "$1" "$3"
  case "$3" in fails*) failures=$((failures + 1)) ;; esac
}
# verdict LOG STATUS PATTERN: works when the status is 0 (or the time-out's 124) and the log holds the pattern.
verdict() {
  if { [ "$2" = 0 ] || [ "$2" = 124 ]; } && { [ -z "$3" ] || grep -qE "$3" "$1"; } && ! grep -qE 'pineda: error|DEVICE_LOST' "$1"; then
    echo works
  else
    echo "fails: $(grep -m1 -iE 'pineda: error|error|fail|assert|not supported|required' "$1" | tr '|\n' '/ ' | cut -c1-160)"
  fi
}
# window NAME SECONDS COMMAND...: runs a program with a window and keeps a picture of it; prints the verdict. A picture of one colour is
# a failure.
window() {
  local name=$1 seconds=$2 status colors
  shift 2
  [ -n "$display_started" ] || { echo "skipped: Xvfb is not installed"; return; }
  timeout "$seconds" "$@" >"$work/$name.log" 2>&1 &
  local pid=$!
  sleep $((seconds - 2))
  have import && import -window root "$out/clients/$name.png" 2>/dev/null
  wait "$pid"
  status=$?
  colors=$(have identify && identify -format %k "$out/clients/$name.png" 2>/dev/null || echo 2)
  if [ "$colors" -lt 2 ]; then echo "fails: nothing on the screen; $(tail -1 "$work/$name.log" | tr '|' '/')"; else
    verdict "$work/$name.log" "$status" '' ; fi
}

client_vulkaninfo() {
  have vulkaninfo || { row vulkaninfo - 'skipped: not installed' vulkaninfo; return; }
  vulkaninfo >"$work/info.log" 2>"$work/info.err"
  row vulkaninfo "$(version vulkan-tools)" "$(verdict "$work/info.log" $? 'deviceName *= Pineda')" vulkaninfo
}
client_vkcube() {
  have vkcube || { row vkcube - 'skipped: not installed' vkcube; return; }
  local mode
  for mode in 0 1 2; do  # VkPresentModeKHR: immediate, mailbox, FIFO
    row 'vkcube, X11' "$(version vulkan-tools)" "$(window vkcube 4 vkcube --present_mode $mode)" "vkcube --present_mode $mode"
  done
}
client_vkcube_wayland() {
  { have weston && have vkcube-wayland; } || { row 'vkcube, Wayland' - 'skipped: weston is not installed' vkcube-wayland; return; }
  weston --backend=headless-backend.so --socket=wl-pineda --use-pixman --idle-time=0 >"$work/weston.log" 2>&1 &
  pids+=($!)
  for _ in $(seq 50); do [ -S "$work/wl-pineda" ] && break; sleep 0.1; done
  local mode status
  for mode in 1 2; do  # VkPresentModeKHR: mailbox, FIFO
    WAYLAND_DISPLAY=wl-pineda timeout 20 vkcube-wayland --present_mode $mode --c 100 >"$work/wayland.log" 2>&1
    status=$?
    [ "$status" = 124 ] && status=1
    row 'vkcube, Wayland' "$(version vulkan-tools)" "$(verdict "$work/wayland.log" $status 'Pineda')" "vkcube-wayland --present_mode $mode --c 100"
  done
}
client_vkd3d() {
  for demo in vkd3d-triangle vkd3d-gears; do
    have $demo || { row $demo - 'skipped: not installed' $demo; continue; }
    row "$demo (Direct3D 12)" "$(version vkd3d-demos)" "$(window $demo 6 $demo)" $demo
  done
}
client_gfxrecon() {
  have gfxrecon-replay || { row gfxrecon - 'skipped: not installed' gfxrecon-replay; return; }
  [ -n "$display_started" ] || { row gfxrecon - 'skipped: Xvfb is not installed' gfxrecon-replay; return; }
  (cd "$work" && VK_DRIVER_FILES=$lavapipe VK_ICD_FILENAMES=$lavapipe VK_INSTANCE_LAYERS=VK_LAYER_LUNARG_gfxreconstruct \
    GFXRECON_CAPTURE_FILE=cube.gfxr GFXRECON_CAPTURE_FILE_TIMESTAMP=false timeout 60 vkcube --c 20) >"$work/capture.log" 2>&1
  "$build/pineda" compare --capture "$work/cube.gfxr" --out "$out/clients/gfxrecon" >"$work/replay.log" 2>&1
  row 'gfxrecon: vkcube captured on lavapipe, replayed on both' "$(version gfxreconstruct)" \
    "$(verdict "$work/replay.log" $? 'frames')" 'pineda compare --capture cube.gfxr'
}
client_validation() {
  "$build/pineda" golden --validate "$here/../golden/scenes.txt" >"$work/validation.log" 2>&1
  row 'validation layer' "$(version vulkan-validationlayers)" "$(verdict "$work/validation.log" $? '')" 'pineda golden --validate'
  VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT \
    "$build/pineda" golden --validate "$here/../golden/scenes.txt" >"$work/validation.log" 2>&1
  row 'validation layer, synchronization' "$(version vulkan-validationlayers)" "$(verdict "$work/validation.log" $? '')" 'the same'
}
# Mesa's loader takes Zink as a driver with windows of its own; GALLIUM_DRIVER alone draws into nothing, on any Vulkan driver.
client_zink() {
  export LIBGL_ALWAYS_SOFTWARE=1 GALLIUM_DRIVER=zink MESA_LOADER_DRIVER_OVERRIDE=zink
  have glxgears && row 'glxgears (OpenGL, Zink)' "$(version libgl1-mesa-dri)" "$(window glxgears 6 glxgears -info)" glxgears
  if have glmark2; then
    row 'glmark2 (OpenGL, Zink)' "$(version glmark2-x11)" "$(window glmark2 8 glmark2 -b terrain:duration=9)" 'glmark2 -b terrain'
    timeout 180 glmark2 --validate --size 300x225 >"$work/glmark2.log" 2>&1
    local status=$?
    grep -q 'Validation: Failure' "$work/glmark2.log" && status=1
    row 'glmark2, all scenes (OpenGL, Zink)' "$(version glmark2-x11)" \
      "$(verdict "$work/glmark2.log" $status 'Validation: Success'), $(grep -c 'Validation: Success' "$work/glmark2.log") scenes checked" \
      'glmark2 --validate'
  fi
  unset LIBGL_ALWAYS_SOFTWARE GALLIUM_DRIVER MESA_LOADER_DRIVER_OVERRIDE
}
client_qt() {
  local qml=/usr/lib/qt6/bin/qml
  [ -x $qml ] || { row 'Qt Quick' - 'skipped: not installed' qml; return; }
  export QSG_RHI_BACKEND=vulkan QSG_INFO=1
  row 'Qt Quick' "$(version qml6-module-qtquick)" "$(window qt 7 $qml "$here/quick.qml")" \
    'QSG_RHI_BACKEND=vulkan qml tests/clients/quick.qml'
  unset QSG_RHI_BACKEND QSG_INFO
}
client_mpv() {
  { have mpv && have ffmpeg; } || { row 'mpv, libplacebo' - 'skipped: not installed' mpv; return; }
  ffmpeg -v error -f lavfi -i testsrc2=size=320x240:rate=10:duration=2 -pix_fmt yuv420p -c:v mpeg4 -y "$work/clip.mp4"
  local device
  device=$(vulkaninfo --summary 2>/dev/null | sed -n 's/.*deviceName *= //p')
  row 'mpv (libplacebo)' "$(version mpv)" "$(window mpv 7 mpv --no-config --gpu-api=vulkan --gpu-context=x11vk --vulkan-device="$device" \
    --vo=gpu --loop "$work/clip.mp4")" 'mpv --gpu-api=vulkan --vulkan-device="Pineda ..." clip.mp4'
}
client_gstreamer() {
  have gst-launch-1.0 || { row 'GStreamer' - 'skipped: not installed' gst-launch-1.0; return; }
  row 'GStreamer, vulkansink' "$(version gstreamer1.0-plugins-bad)" "$(window gstreamer 7 gst-launch-1.0 videotestsrc ! \
    video/x-raw,format=RGBA,width=320,height=240 ! vulkanupload ! vulkancolorconvert ! vulkansink)" 'videotestsrc ! vulkanupload ! vulkancolorconvert ! vulkansink'
}
client_sdl() {
  local program=/usr/libexec/installed-tests/SDL2/testvulkan
  [ -x $program ] || { row 'SDL testvulkan' - 'skipped: not installed' testvulkan; return; }
  row 'SDL testvulkan' "$(version libsdl2-tests)" "$(window sdl 5 $program)" testvulkan
}
# What FFmpeg uploads it gets back. Its filters declare rgba8 for images of R8 (undefined in Vulkan), so their output is not looked at.
client_ffmpeg() {
  have ffmpeg || { row 'FFmpeg' - 'skipped: not installed' ffmpeg; return; }
  local filter source='testsrc2=size=320x240:rate=10:duration=1'
  for filter in format=yuv420p,hwupload,hwdownload,format=yuv420p format=yuv420p; do
    timeout 60 ffmpeg -v error -init_hw_device vulkan=v:0 -filter_hw_device v -f lavfi -i $source -vf $filter -f framemd5 - \
      >"$work/$filter.md5" 2>>"$work/ffmpeg.log"
  done
  cmp -s "$work/format=yuv420p.md5" "$work/format=yuv420p,hwupload,hwdownload,format=yuv420p.md5"
  row 'FFmpeg, hwupload and hwdownload' "$(version ffmpeg)" "$(verdict "$work/ffmpeg.log" $? '')" 'ffmpeg -vf hwupload,hwdownload'
}
client_chromium() {
  have chromium || { row 'Chromium, WebGL 2' - 'skipped: not installed' chromium; return; }
  timeout 90 chromium --headless=new --no-sandbox --user-data-dir="$work/chromium" --ignore-gpu-blocklist --use-gl=angle \
    --use-angle=vulkan --enable-logging=stderr --virtual-time-budget=5000 --dump-dom \
    --screenshot="$out/clients/chromium.png" --window-size=420,340 "file://$here/webgl2.html" >"$work/chromium.log" 2>&1
  row 'Chromium, WebGL 2 (ANGLE)' "$(version chromium)" "$(verdict "$work/chromium.log" $? 'pixels right.*Pineda')" \
    'chromium --headless=new --use-angle=vulkan tests/clients/webgl2.html'
}
client_dawn() {
  { have node && have npm; } || { row 'Dawn, WebGPU in Node' - 'skipped: node is not installed' node; return; }
  (cd "$work" && npm install --silent --no-fund --no-audit webgpu@0.3.8) >"$work/npm.log" 2>&1 \
    || { row 'Dawn, WebGPU in Node' - 'skipped: npm could not install webgpu' node; return; }
  cp "$here/webgpu.mjs" "$work/"
  (cd "$work" && timeout 60 node webgpu.mjs) >"$work/dawn.log" 2>&1
  row 'Dawn, WebGPU in Node' "$(node -p "require('$work/node_modules/webgpu/package.json').version")" \
    "$(verdict "$work/dawn.log" $? 'all right')" 'node tests/clients/webgpu.mjs'
}

start_display || true
all=(vulkaninfo vkcube vkcube_wayland vkd3d gfxrecon validation zink qt mpv gstreamer sdl ffmpeg chromium dawn)
{
  echo '# Programs that nobody here wrote'
  echo
  echo "On $("$build/pineda" --version 2>/dev/null || echo Pineda), $(date -u +%F)."
  echo
  echo '| program | version | result | command |'
  echo '|---|---|---|---|'
} >"$out/clients.md"
for client in "${@:-${all[@]}}"; do "client_$client"; done
echo "$out/clients.md"
exit $((failures > 0))
