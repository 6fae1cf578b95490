"""A capture is read by numpy with no help from us: every buffer, and enough arithmetic on them to know what they are.

  numpy_reads_captures.py SCOTTY
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

SPP, WIDTH, HEIGHT = 2, 9, 7

with tempfile.TemporaryDirectory() as folder:
    capture = pathlib.Path(folder) / "capture"
    subprocess.run([sys.argv[1], "capture", "spheres", "-o", capture, "--size", f"{WIDTH}x{HEIGHT}", "--spp", str(SPP),
                    "--early-out", "off"], check=True)
    index = json.loads((capture / "index.json").read_text(encoding="utf-8"))
    stages = {}
    buffers = 0
    for stage in index["stages"]:
        arrays = stages[stage["name"]] = {}
        for record in stage["inputs"] + stage["outputs"]:
            array = np.load(capture / record["file"], allow_pickle=False)
            assert list(array.shape) == record["shape"], (stage["name"], record, array.shape)
            assert array.dtype == np.dtype(record["type"]), (stage["name"], record, array.dtype)
            arrays[record["name"]] = array
            buffers += 1

first = stages["primary_rays"]
rays = first["rays"]
assert rays.shape == (SPP * WIDTH * HEIGHT, 8)
assert np.allclose(np.linalg.norm(rays[:, 4:7].astype(np.float64), axis=1), 1.0, atol=1e-6), "unit directions"
assert np.array_equal(np.unique(first["pixel"]), np.arange(WIDTH * HEIGHT)), "every pixel"

merged = stages["bounce0/merge_intersections"]["merged"]
primitive = merged[:, 1]
t = merged[:, 0].view(np.float32)
assert np.array_equal(primitive == 0xFFFFFFFF, np.isinf(t)), "a miss is at infinity"
assert (t[np.isfinite(t)] > 0).all()

for name, stage in stages.items():
    if name.endswith("/scan_counts"):
        blocks = -(-stage["node_counts"].astype(np.int64) // index["parameters"]["rays_per_block"])
        assert np.array_equal(stage["block_offsets"], np.concatenate([[0], np.cumsum(blocks)])), name

last = stages["reconstruct_image"]
radiance = last["radiance"].reshape(HEIGHT * WIDTH, SPP, 3)
mean = (radiance[:, 0] + radiance[:, 1]) / np.float32(SPP)
assert np.array_equal(mean.astype(np.float32), last["image"]), "the image is the mean of its samples"
print(f"{buffers} buffers of {len(stages)} stages")
