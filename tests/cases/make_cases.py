#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the DEMs of this folder again from files of Debian packages.

  tests/cases/make_cases.py TRINIDAD_NC MATPLOTLIB_SAMPLE_DATA

TRINIDAD_NC: /usr/share/ncarg/data/cdf/trinidad.nc of libncarg-data; MATPLOTLIB_SAMPLE_DATA: the folder
/usr/share/matplotlib/mpl-data/sample_data of python-matplotlib-data. Needs gdal-bin.
"""
import ast
import pathlib
import struct
import subprocess
import sys
import tempfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
PACKED = ["-co", "COMPRESS=DEFLATE", "-co", "ZLEVEL=9"]


def gdal(*command):
    subprocess.run([str(c) for c in command], check=True)


def array_of(archive, name):
    """(rows, columns, bytes, numpy type) of an array in an .npz file."""
    data = zipfile.ZipFile(archive).read(name + ".npy")
    end = 10 + struct.unpack("<H", data[8:10])[0]
    header = ast.literal_eval(data[10:end].decode())
    rows, columns = header["shape"]
    return rows, columns, data[end:], header["descr"]


def from_array(archive, name, north_up, corner, pixel, crs, scratch, out):
    rows, columns, data, kind = array_of(archive, name)
    size = struct.calcsize({"<i2": "h", "<f4": "f"}[kind])
    if not north_up:
        line = columns * size
        data = b"".join(data[k * line:(k + 1) * line] for k in reversed(range(rows)))
    raw, header = scratch / f"{name}.bil", scratch / f"{name}.hdr"
    raw.write_bytes(data)
    header.write_text(f"NROWS {rows}\nNCOLS {columns}\nNBANDS 1\nNBITS {8 * size}\nBYTEORDER I\nLAYOUT BIL\n"
                      f"PIXELTYPE {'FLOAT' if kind == '<f4' else 'SIGNEDINT'}\n")
    gdal("gdal_translate", "-q", "-a_srs", crs, "-a_ullr", corner[0], corner[1], corner[0] + columns * pixel[0],
         corner[1] - rows * pixel[1], *PACKED, "-co", f"PREDICTOR={3 if kind == '<f4' else 2}", raw, out)


def main():
    trinidad, samples = sys.argv[1], pathlib.Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        gdal("gdal_translate", "-q", "-a_srs", "EPSG:4326", "-ot", "Int16", "-srcwin", 420, 300, 400, 360, *PACKED, "-co",
             "PREDICTOR=2", trinidad, HERE / "blanca_peak_feet.tif")
        gdal("gdalwarp", "-q", "-overwrite", "-s_srs", "EPSG:4326", "-t_srs", "EPSG:26913", "-tr", 90, 90, "-te", 535000, 4084000,
             559000, 4110000, "-r", "cubic", "-dstnodata", "nan", trinidad, scratch / "peaks.tif")
        # South of 37 degrees there are no data: a slanted rim, and holes beyond it.
        gdal("gdal_translate", "-q", *PACKED, "-co", "PREDICTOR=3", scratch / "peaks.tif", HERE / "raton_mesa_utm.tif")
        fault = samples / "jacksboro_fault_dem.npz"
        from_array(fault, "elevation", True, (-84.41375, 36.73291), (0.00083333, 0.00083333), "EPSG:4326", scratch,
                   HERE / "jacksboro_fault.tif")
        from_array(samples / "topobathy.npz", "topo", False, (0, 91 * 2000), (2000, 2000), "EPSG:32610", scratch,
                   HERE / "vancouver_topobathy.tif")


if __name__ == "__main__":
    main()
