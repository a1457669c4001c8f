// Style and script of the report page. All in the page itself, so that it opens from disk.
#pragma once

namespace pineda::tools {

inline constexpr const char* kReportStyle = R"css(
:root { color-scheme: light dark; --page: #f6f7f9; --card: #ffffff; --text: #1d2330; --soft: #626c7e; --line: #e2e6ed;
  --accent: #2f6fed; --good: #18794e; --good-back: #ddf3e4; --bad: #b4232c; --bad-back: #fde5e5; --picture: #e9ecf1; }
@media (prefers-color-scheme: dark) { :root { --page: #12151b; --card: #1a1f28; --text: #e6e9ef; --soft: #98a2b3; --line: #2b3240;
  --accent: #7aa7ff; --good: #6fd69a; --good-back: #17382a; --bad: #ff9a9a; --bad-back: #45201f; --picture: #0d1015; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--text); font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main { max-width: 1320px; margin: 0 auto; padding: 40px 24px 80px; }
h1 { font-size: 30px; line-height: 1.2; margin: 0; letter-spacing: -0.02em; }
h2 { font-size: 21px; margin: 0; letter-spacing: -0.01em; }
p { margin: 6px 0 0; color: var(--soft); }
a { color: var(--accent); text-decoration: none; }
a:hover { text-decoration: underline; }
header { display: flex; flex-wrap: wrap; align-items: flex-start; gap: 16px; justify-content: space-between; margin-bottom: 28px; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 14px; padding: 24px; margin-bottom: 24px; }
.title { display: flex; align-items: center; gap: 12px; }
.verdict { display: inline-block; padding: 3px 12px; border-radius: 999px; font-weight: 600; font-size: 13px; white-space: nowrap; }
.verdict.good { color: var(--good); background: var(--good-back); }
.verdict.bad { color: var(--bad); background: var(--bad-back); }
header .verdict { font-size: 16px; padding: 7px 18px; }
.scroll { overflow-x: auto; margin-top: 16px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th { font-size: 12px; font-weight: 600; color: var(--soft); text-align: right; border-bottom: 1px solid var(--line); vertical-align: bottom; }
td { text-align: right; border-bottom: 1px solid var(--line); }
th, td { padding: 8px 12px; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
th:last-child, td:last-child { padding-right: 0; }
tr:last-child td { border-bottom: 0; }
td.wrap { white-space: normal; text-align: left; }
.soft { color: var(--soft); }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(300px, 1fr)); gap: 16px; margin-top: 18px; }
figure { margin: 0; min-width: 0; }
figure img { display: block; width: 100%; height: auto; border-radius: 8px; background: var(--picture); cursor: zoom-in; }
figcaption { margin-top: 8px; font-size: 13px; color: var(--soft); }
figcaption b { color: var(--text); font-weight: 600; }
.problem { background: var(--bad-back); color: var(--bad); border-radius: 8px; padding: 10px 14px; margin: 14px 0 0; white-space: pre-wrap;
  overflow-wrap: anywhere; font: 13px/1.45 ui-monospace, "SF Mono", Menlo, Consolas, monospace; }
.legend { display: flex; flex-wrap: wrap; gap: 6px 16px; font-size: 13px; color: var(--soft); margin-top: 14px; }
.legend i { display: inline-block; width: 12px; height: 12px; border-radius: 3px; margin-right: 6px; vertical-align: -1px;
  box-shadow: inset 0 0 0 1px rgb(128 128 128 / 40%); }
dialog { border: 0; padding: 0; margin: 0; max-width: none; max-height: none; width: 100vw; height: 100vh; background: rgb(10 12 16 / 96%);
  color: #e6e9ef; }
dialog div { position: absolute; inset: 44px 0 0 0; overflow: auto; display: flex; }
dialog img { margin: auto; image-rendering: pixelated; }
dialog p { position: absolute; top: 10px; left: 20px; right: 20px; margin: 0; color: #c3cad6; }
)css";

// A click opens a picture at its own size; the arrow keys flip between the pictures of its scene in place, + and - zoom.
inline constexpr const char* kReportScript = R"js(
const dialog = document.querySelector('dialog'), large = dialog.querySelector('img'), caption = dialog.querySelector('p');
let pictures = [], at = 0, zoom = 1;
function show() {
  large.src = pictures[at].src;
  large.style.width = pictures[at].naturalWidth * zoom + 'px';
  caption.textContent = pictures[at].alt + '  (' + (at + 1) + ' of ' + pictures.length + '; \u2190 \u2192 flip, + \u2212 zoom, Esc closes)';
}
document.querySelectorAll('figure img').forEach(img => img.addEventListener('click', () => {
  pictures = [...img.closest('.pictures').querySelectorAll('img')];
  at = pictures.indexOf(img); zoom = 1; show(); dialog.showModal();
}));
dialog.addEventListener('click', () => dialog.close());
document.addEventListener('keydown', event => {
  if (!dialog.open) return;
  if (event.key === 'ArrowRight') at = (at + 1) % pictures.length;
  else if (event.key === 'ArrowLeft') at = (at + pictures.length - 1) % pictures.length;
  else if (event.key === '+') zoom = Math.min(16, zoom * 2);
  else if (event.key === '-') zoom = Math.max(1, zoom / 2);
  else return;
  event.preventDefault(); show();
});
)js";

}  // namespace pineda::tools
