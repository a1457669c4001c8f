#!/usr/bin/env python3
"""Collects the shaders that Debian packages ship and turns them into SPIR-V for `pineda_fuzz corpus`.

usage: collect.py OUT [--per-folder N] [--jobs N]

OUT gets a folder for each source: piglit's GLSL tests (shader_test files and plain ones), its Vulkan tests and its SPIR-V, glmark2's
shaders, the DXBC in vkd3d's demos by way of vkd3d-compiler, and the kernels that VkFFT generates (vkfft_kernels.cpp). Desktop GLSL is
not Vulkan GLSL: what is only spelled differently is respelled here, and glslang's relaxed rules do the rest; what it still refuses, or
makes of it against spirv-val's judgement, is counted and left out. Of generated folders with hundreds of near copies every k-th file is
taken, so that at most N remain; the choice does not depend on the machine. OUT/collected.md tells what became of them.
"""
import argparse
import collections
import concurrent.futures
import hashlib
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

STAGES = {"vertex shader": "vert", "fragment shader": "frag", "compute shader": "comp"}
PIGLIT = pathlib.Path("/usr/lib/x86_64-linux-gnu/piglit")
ROOTS = {"piglit": PIGLIT / "tests", "piglit-generated": PIGLIT / "generated_tests", "glmark2": pathlib.Path("/usr/share/glmark2/shaders")}
DEMOS = [pathlib.Path("/usr/bin/vkd3d-gears"), pathlib.Path("/usr/bin/vkd3d-triangle")]
LAVAPIPE = "/usr/share/vulkan/icd.d/lvp_icd.x86_64.json"
GLSLANG_LIBRARIES = ["glslang", "MachineIndependent", "OSDependent", "OGLCompiler", "GenericCodeGen", "HLSL", "SPIRV",
                     "SPIRV-Tools-opt", "SPIRV-Tools", "glslang-default-resource-limits", "vulkan", "pthread"]


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


def chosen_files(root, per_folder):
    folders = collections.defaultdict(list)
    for path in sorted(root.rglob("*")):
        if path.suffix in (".shader_test", ".vert", ".frag", ".comp"):
            folders[path.parent].append(path)
    for folder in sorted(folders):
        files = folders[folder]
        step = -(-len(files) // per_folder)
        yield from files[::step]


def glsl_jobs(out, per_folder):
    """(source, (stage, GLSL, target)) for every distinct shader that could be one; and, by reason, how many could not."""
    seen, jobs, left_out = set(), [], collections.Counter()

    def job(source, path, stage, text):
        if re.search(r"expect_result:\s*fail", text):
            left_out["tests that a compiler must refuse"] += 1
            return []
        if not re.search(r"\bmain\s*\(", text):
            left_out["parts of programs and tests of the parser, without main()"] += 1
            return []
        digest = hashlib.sha256((stage + text).encode()).hexdigest()[:16]
        if digest in seen:
            return []
        seen.add(digest)
        return [(source, (stage, text, out / source / f"{path.stem[:60]}-{digest}.{stage}.spv"))]

    for source, root in ROOTS.items():
        for path in chosen_files(root, per_folder):
            for stage, text in sections(path):
                jobs.extend(job(source, path, stage, respelled(stage, text)))
    for path in sorted(PIGLIT.rglob("*.vk_shader_test")):  # Vulkan's GLSL already
        for stage, text in sections(path):
            jobs.extend(job("piglit-vulkan", path, stage, text))
    return jobs, left_out


def copy_modules(out):
    """piglit's own SPIR-V."""
    (out / "piglit-spirv").mkdir(exist_ok=True)
    files = [path for root in ROOTS.values() for path in sorted(root.rglob("*.spv"))]
    for path in files:
        (out / "piglit-spirv" / path.name).write_bytes(path.read_bytes())
    return len(files)


def translate_dxbc(out):
    """The Direct3D byte code in vkd3d's demos: (found, translated)."""
    (out / "vkd3d").mkdir(exist_ok=True)
    found = translated = 0
    for demo in DEMOS:
        data = demo.read_bytes() if demo.exists() else b""
        at = data.find(b"DXBC")
        while at >= 0:
            found += 1
            size = struct.unpack_from("<I", data, at + 24)[0]
            target = out / "vkd3d" / f"{demo.name}-{at}.spv"
            done = subprocess.run(["vkd3d-compiler", "-x", "dxbc-tpf", "-b", "spirv-binary", "-o", str(target), "-"],
                                  input=data[at:at + size], capture_output=True)
            translated += done.returncode == 0 and target.exists()
            at = data.find(b"DXBC", at + 4)
    return found, translated


def generate_vkfft(out):
    """How many kernels VkFFT made. It needs a Vulkan device, any one, to make them for: lavapipe."""
    (out / "vkfft").mkdir(exist_ok=True)
    header = pathlib.Path("/usr/include/vkFFT.h").read_text()
    # The header fills glslang's limits by position; glslang 12 has nine more before this one.
    header = header.replace("/* .maxDualSourceDrawBuffersEXT = */", "256, 512, 32, 1, 1, 32, 1, 1, 4, /* .maxDualSourceDrawBuffersEXT = */")
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "vkFFT.h").write_text(header)
        program = pathlib.Path(folder) / "vkfft_kernels"
        source = pathlib.Path(__file__).with_name("vkfft_kernels.cpp")
        subprocess.run(["g++", "-std=c++20", "-O0", "-w", f"-I{folder}", str(source), "-o", str(program)] +
                       [f"-l{name}" for name in GLSLANG_LIBRARIES], check=True)
        environment = dict(os.environ, VK_DRIVER_FILES=LAVAPIPE, VK_ICD_FILENAMES=LAVAPIPE)
        subprocess.run([str(program), str(out / "vkfft")], check=True, env=environment)
    return len(list((out / "vkfft").glob("*.spv")))


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
        said = (checked.stderr + checked.stdout).strip().splitlines()
        return "(made by glslang, refused by spirv-val) " + (re.sub(r"^error: (line )?\d+: |\d+(\[%[^\]]*\])?", "", said[0]) if said else "")
    found = re.search(r"ERROR: (?:\S+:\d+: )?(.*)", done.stdout)
    return found.group(1) if found else "no message"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--per-folder", type=int, default=12)
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    jobs, left_out = glsl_jobs(args.out, args.per_folder)
    for source in {source for source, _ in jobs}:
        (args.out / source).mkdir(exist_ok=True)
    refused = collections.Counter()
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for complaint in pool.map(compile_one, [job for _, job in jobs]):
            if complaint is not None:
                refused[re.sub(r"'[^']*'", "''", complaint)] += 1
    made = len(jobs) - sum(refused.values())
    lines = [f"- {len(jobs)} shaders in GLSL: {made} became SPIR-V, {sum(refused.values())} glslang refuses",
             f"- {copy_modules(args.out)} modules that piglit has as SPIR-V"]
    lines += [f"- {count} left out: {reason}" for reason, count in left_out.most_common()]
    lines.append("- {} shaders in the byte code of Direct3D: {} translated by vkd3d".format(*translate_dxbc(args.out)))
    lines.append(f"- {generate_vkfft(args.out)} kernels that VkFFT generated")
    lines += ["", "What glslang says of those that it refuses:", ""]
    lines += [f"- {count}: {reason}" for reason, count in refused.most_common(12)]
    (args.out / "collected.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
