#!/usr/bin/env python3
"""Prints base/srgb_tables.inc: the sRGB transfer function at the points that 8-bit formats need.

decode[c]     the binary32 nearest to the linear value of code c
threshold[c]  the smallest binary32 whose sRGB value rounds to code c or higher (c >= 1)

All arithmetic is decimal with 60 digits; the transfer function is that of the Khronos Data Format Specification 1.3, section 13.3.
"""
import struct
from decimal import Decimal as D, getcontext

getcontext().prec = 60


def power(x, y):
    return (y * x.ln()).exp()


def decode(s):  # sRGB value -> linear
    return s / D("12.92") if s <= D("0.04045") else power((s + D("0.055")) / D("1.055"), D("2.4"))


def bits_to_float(bits):
    return struct.unpack("<f", struct.pack("<I", bits))[0]


def nearest(x):  # decimal -> nearest binary32
    bits = struct.unpack("<I", struct.pack("<f", float(x)))[0]
    return bits_to_float(min((bits - 1, bits, bits + 1), key=lambda b: abs(D(bits_to_float(b)) - x) if b >= 0 else D(9)))


def at_least(x):  # smallest binary32 >= x
    bits = struct.unpack("<I", struct.pack("<f", float(x)))[0] + 2
    while D(bits_to_float(bits - 1)) >= x:
        bits -= 1
    return bits_to_float(bits)


def hex_float(v):
    mantissa, exponent = v.hex().split("p")
    return mantissa.rstrip("0").rstrip(".") + "p" + exponent + "f"


def table(name, values, comment):
    print(f"// {comment}\nalignas(64) constexpr float {name}[256] = {{")
    for i in range(0, 256, 8):
        print("    " + ", ".join(hex_float(v) for v in values[i:i + 8]) + ",")
    print("};")


print("// Made by tools/math/srgb_tables.py; do not edit.")
table("kDecode", [0.0] + [nearest(decode(D(c) / 255)) for c in range(1, 256)], "linear value of each code, to nearest")
table("kThreshold", [0.0] + [at_least(decode((D(c) - D("0.5")) / 255)) for c in range(1, 256)],
      "smallest value that rounds to the code or a higher one")
