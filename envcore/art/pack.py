#!/usr/bin/env python3
"""Packs PNG files into one blob that is linked into the library.

    pack.py LIST BLOB

LIST: one image per line: name, tab, path of the PNG file.
BLOB: the number of images, the lengths of name and file of each image (little-endian 32-bit
numbers), all names, all files.
"""

import struct
import sys

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def read_pictures(list_path):
    pictures = []
    with open(list_path, encoding="utf-8") as lines:
        for line in lines:
            name, path = line.rstrip("\n").split("\t")
            with open(path, "rb") as file:
                png = file.read()
            if not png.startswith(PNG_SIGNATURE):
                sys.exit(f"pack.py: image {name}: {path} is not a PNG file")
            pictures.append((name.encode(), png))
    return pictures


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    pictures = read_pictures(sys.argv[1])
    with open(sys.argv[2], "wb") as blob:
        blob.write(struct.pack("<I", len(pictures)))
        for name, png in pictures:
            blob.write(struct.pack("<II", len(name), len(png)))
        blob.write(b"".join(name for name, _ in pictures))
        blob.write(b"".join(png for _, png in pictures))


if __name__ == "__main__":
    main()
