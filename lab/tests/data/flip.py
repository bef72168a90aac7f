"""Measures the picture pairs in a folder with the authors' FLIP: pip install flip-evaluator==1.7 pillow numpy"""
import glob, os, sys
import flip_evaluator, numpy
from PIL import Image

PROBES = [(0.0, 0.0), (0.5, 0.5), (0.25, 0.75), (0.99, 0.3)]

def load(path):
    return numpy.asarray(Image.open(path).convert("RGB"), dtype=numpy.float32) / 255

print("pair,pixels per degree,mean," + ",".join(f"at {x} {y}" for x, y in PROBES))
for ppd in [67.0206, 30.0]:
    for reference in sorted(glob.glob(os.path.join(sys.argv[1], "*reference.png"))):
        test = reference.replace("reference.png", "test.png")
        values, mean, _ = flip_evaluator.evaluate(load(reference), load(test), "LDR", applyMagma=False, parameters={"ppd": ppd})
        values = numpy.asarray(values).squeeze()
        height, width = values.shape
        probes = [values[int(y * height), int(x * width)] for x, y in PROBES]
        name = os.path.basename(reference).split(" ", 1)[1].removesuffix(" reference.png")
        print(",".join([name] + [f"{number:.6g}" for number in [ppd, mean] + probes]))
