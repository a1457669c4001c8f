#!/usr/bin/env python3
"""Collects the shaders that Debian packages ship and turns them into SPIR-V for `pineda_fuzz corpus`.

usage: collect.py OUT [--per-folder N] [--jobs N]

Sources: piglit's GLSL tests (shader_test files and plain ones) and its SPIR-V, and glmark2's shaders. Desktop GLSL is not Vulkan GLSL: what is only spelled differently is respelled here, and glslang's
relaxed rules do the rest; what it still refuses, or makes of it against
spirv-val's judgement, is counted and left out. Of generated folders with hundreds of near copies every
k-th file is taken, so that at most N remain; the choice does not depend on the machine.
"""
import argparse
import collections
import concurrent.futures
import hashlib
import pathlib
import re
import subprocess
import sys

STAGES = {"vertex shader": "vert", "fragment shader": "frag", "compute shader": "comp"}
PIGLIT = pathlib.Path("/usr/lib/x86_64-linux-gnu/piglit")
ROOTS = [PIGLIT / "tests", PIGLIT / "generated_tests", pathlib.Path("/usr/share/glmark2/shaders")]


def sections(path):
    """The (stage, GLSL) pairs of a file."""
    text = path.read_text(errors="replace")
    if path.suffix[1:] in STAGES.values():
        return [(path.suffix[1:], text)]
    out, stage, lines = [], None, []
    for line in text.splitlines():
        header = re.match(r"\[([^\]]*)\]\s*$", line)
        if header:
            if stage:
                out.append((stage, "\n".join(lines)))
            stage, lines = STAGES.get(header.group(1)), []
        else:
            lines.append(line)
    if stage:
        out.append((stage, "\n".join(lines)))
    return out


RENAMED = {
    r"\btexture[123]D\b": "texture", r"\btextureCube\b": "texture", r"\btexture[123]DLod\b": "textureLod",
    r"\btexture[123]DProj\b": "textureProj", r"\bshadow[12]D\b": "texture", r"\btexture2DGradARB\b": "textureGrad",
    r"\bgl_FragColor\b": "pc_color", r"\bgl_FragData\b": "pc_data", r"\bgl_Vertex\b": "pc_vertex", r"\bgl_Normal\b": "pc_normal",
    r"\bgl_Color\b": "pc_in_color", r"\bgl_MultiTexCoord0\b": "pc_coord", r"\bgl_FrontColor\b": "pc_front_color",
    r"\bgl_ModelViewProjectionMatrix\b": "pc_mvp", r"\bgl_ModelViewMatrix\b": "pc_mv", r"\bgl_NormalMatrix\b": "pc_nm",
    r"\bgl_TexCoord\b": "pc_tex", r"\bgl_VertexID\b": "gl_VertexIndex", r"\bgl_InstanceID\b": "gl_InstanceIndex",
    r"\bftransform\s*\(\s*\)": "(pc_mvp * pc_vertex)",
}
DECLARED = {
    "pc_color": "out vec4 pc_color;", "pc_data": "out vec4 pc_data[4];", "pc_vertex": "in vec4 pc_vertex;",
    "pc_normal": "in vec3 pc_normal;", "pc_in_color": "in vec4 pc_in_color;", "pc_coord": "in vec4 pc_coord;",
    "pc_front_color": "out vec4 pc_front_color;", "pc_mvp": "uniform mat4 pc_mvp;", "pc_mv": "uniform mat4 pc_mv;",
    "pc_nm": "uniform mat3 pc_nm;",
}


def respelled(stage, text):
    version = re.search(r"^[ \t]*#[ \t]*version[ \t]+(\d+)", text, re.M)
    es = bool(re.search(r"^[ \t]*#[ \t]*version[ \t]+\d+[ \t]+es", text, re.M))
    if es:
        text = re.sub(r"^\s*precision\s+\w+\s+\w+\s*;", "", text, flags=re.M)
    text = re.sub(r"^[ \t]*#[ \t]*version.*$", "", text, flags=re.M)
    text = re.sub(r"^([ \t]*#[ \t]*extension[ \t]+\w+[ \t]*:[ \t]*)(require|enable)", r"\1warn", text, flags=re.M)
    text = re.sub(r"^([ \t]*)invariant\s+varying\b", r"\1" + ("in" if stage == "frag" else "out"), text, flags=re.M)
    text = re.sub(r"\bvarying\b", "in" if stage == "frag" else "out", text)
    text = re.sub(r"\battribute\b", "in", text)
    for pattern, name in RENAMED.items():
        text = re.sub(pattern, name, text)
    declarations = [d for name, d in DECLARED.items() if re.search(rf"\b{name}\b", text)]
    if re.search(r"\bpc_tex\b", text):
        declarations.append(f"{'in' if stage == 'frag' else 'out'} vec4 pc_tex[4];")
    extensions = re.findall(r"^[ \t]*#[ \t]*extension.*$", text, re.M)
    text = re.sub(r"^[ \t]*#[ \t]*extension.*$", "", text, flags=re.M)
    number = max(int(version.group(1)) if version else 110, 450)
    return "\n".join([f"#version {number}"] + extensions + declarations + [text])


def chosen_files(per_folder):
    folders = collections.defaultdict(list)
    for root in ROOTS:
        for path in sorted(root.rglob("*")):
            if path.suffix in (".shader_test", ".vert", ".frag", ".comp"):
                folders[path.parent].append(path)
    for folder in sorted(folders):
        files = folders[folder]
        step = -(-len(files) // per_folder)
        yield from files[::step]


def compile_one(job):
    """(stage, GLSL, target) -> None or glslang's first complaint."""
    stage, text, target = job
    command = ["glslangValidator", "-V", "-R", "--target-env", "vulkan1.1", "--auto-map-locations", "--auto-map-bindings", "--stdin", "-S",
               stage, "-o", str(target)]
    done = subprocess.run(command, input=text, capture_output=True, text=True, errors="replace")
    if done.returncode == 0 and target.exists():
        checked = subprocess.run(["spirv-val", "--target-env", "vulkan1.1", str(target)], capture_output=True, text=True, errors="replace")
        if checked.returncode == 0:
            return None
        target.unlink()
        return "(made by glslang, refused by spirv-val) " + checked.stdout.strip().splitlines()[0] if checked.stdout else "(spirv-val)"
    found = re.search(r"ERROR: (?:\S+:\d+: )?(.*)", done.stdout)
    return found.group(1) if found else "no message"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--per-folder", type=int, default=12)
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    jobs, seen = [], set()
    for path in chosen_files(args.per_folder):
        for stage, text in sections(path):
            text = respelled(stage, text)
            digest = hashlib.sha256((stage + text).encode()).hexdigest()[:16]
            if digest not in seen:
                seen.add(digest)
                jobs.append((stage, text, args.out / f"{path.stem[:60]}-{digest}.{stage}.spv"))
    refused = collections.Counter()
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for complaint in pool.map(compile_one, jobs):
            if complaint is not None:
                refused[re.sub(r"'[^']*'", "''", complaint)] += 1
    copied = 0
    for root in ROOTS:
        for path in sorted(root.rglob("*.spv")):
            (args.out / path.name).write_bytes(path.read_bytes())
            copied += 1
    print(f"{len(jobs)} shaders: {len(jobs) - sum(refused.values())} became SPIR-V, {sum(refused.values())} glslang refuses; "
          f"{copied} modules copied")
    for reason, count in refused.most_common(12):
        print(f"  {count:5}  {reason}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
