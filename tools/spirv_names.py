#!/usr/bin/env python3
"""Prints compiler/spirv/names.inc: the names of SPIR-V's instructions and capabilities, from the grammar of spirv-headers.

usage: spirv_names.py [GRAMMAR.json] > compiler/spirv/names.inc
"""
import json
import sys


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else "/usr/include/spirv/unified1/spirv.core.grammar.json"
    with open(path) as file:
        grammar = json.load(file)
    print("// Made by tools/spirv_names.py from the grammar of spirv-headers; compiler/spirv/coverage_test.cpp compares them.")
    print("//   PINEDA_SPIRV_OP(opcode, name, capabilities)   any of the capabilities enables it; empty: always there")
    print("//   PINEDA_SPIRV_CAPABILITY(value, name)")
    seen = set()
    for op in sorted(grammar["instructions"], key=lambda op: op["opcode"]):
        if op["opcode"] in seen:  # another name of the same
            continue
        seen.add(op["opcode"])
        print(f'PINEDA_SPIRV_OP({op["opcode"]}, "{op["opname"]}", "{", ".join(op.get("capabilities", []))}")')
    capabilities = next(kind for kind in grammar["operand_kinds"] if kind["kind"] == "Capability")["enumerants"]
    seen = set()
    for capability in sorted(capabilities, key=lambda c: c["value"]):
        if capability["value"] in seen:
            continue
        seen.add(capability["value"])
        print(f'PINEDA_SPIRV_CAPABILITY({capability["value"]}, "{capability["enumerant"]}")')


if __name__ == "__main__":
    main()
