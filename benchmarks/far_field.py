"""The far field by fast marching, beside the exact field of clsdf: scripts/far-field.

"clsdf compute" makes the exact field of every sample of a cubic grid, and bands of 2, 5 and 10% of the mesh's longest
side. scikit-fmm (second order) continues each band. It cannot keep given distances, so it marches from the surface at
1.5 voxels less than the half width, over the samples that are farther away; the others keep the distances of the band.

Times are of one call, the set-up of the mesh included: of a band, those of "clsdf compute" and of scikit-fmm together.
Errors of scikit-fmm are against the exact field at every sample, in voxels; those of clsdf are by "clsdf check" at
--samples samples, against its reference in double precision.
"""
import argparse
import json
import subprocess
import tempfile
import time

import numpy
import skfmm


def march(band, half_width, voxel):
    """The signed distance everywhere, from a field that has the half width beyond its band."""
    contour = max(half_width - 1.5 * voxel, half_width / 2)
    height = numpy.abs(band).astype(float) - contour
    near = height < -3 * voxel
    marched = skfmm.distance(numpy.ma.MaskedArray(height, near), dx=voxel, order=2)
    far = numpy.abs(band) >= half_width * (1 - 1e-6)
    return numpy.where(far, numpy.copysign(numpy.ma.filled(marched, 0) + contour, band), band)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("--command", required=True)
    parser.add_argument("--resolution", type=int, default=256)
    parser.add_argument("--samples", type=int, default=20000)
    options = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        def run(*arguments):
            outcome = subprocess.run([options.command, *arguments, "--json"], stdout=subprocess.PIPE, check=True)
            return json.loads(outcome.stdout)

        def compute(width):
            file = f"{folder}/field.npy"
            result = run("compute", options.mesh, "-o", file, "--quiet", "--cubic", "--resolution",
                         str(options.resolution), "--margin", "5%", "--band", width)
            return result, numpy.load(file), file

        compute("full")  # warms up
        result, exact, file = compute("full")
        voxel = result["grid"]["spacing"][0]
        check = run("check", options.mesh, file, "--quiet", "--samples", str(options.samples))
        print("| method | s | mean error, voxel | largest error, voxel | off by over 1e-5 voxel | wrong signs | judged |")
        print("|-|-:|-:|-:|-:|-:|-:|")
        full_seconds = result["seconds"]["compute"]
        print(f"| clsdf, every sample | {full_seconds:.3f} | {check['rms_error_voxels']:.2g} (root mean square) "
              f"| {check['max_error_voxels']:.2g} | {check['wrong_values']:,} | {check['wrong_signs']:,} "
              f"| {check['samples']:,} |", flush=True)
        for width in ("2%", "5%", "10%"):
            result, band, _ = compute(width)
            begin = time.perf_counter()
            field = march(band, result["band"]["outside"], voxel)
            seconds = time.perf_counter() - begin + result["seconds"]["compute"]
            error = numpy.abs(numpy.abs(field) - numpy.abs(exact)) / voxel
            wrong = int((~(error <= numpy.maximum(1e-5, 3e-7 * numpy.abs(exact) / voxel))).sum())
            signs = int((numpy.signbit(field) != numpy.signbit(exact)).sum())
            print(f"| band of {width}, scikit-fmm | {seconds:.1f} | {error.mean():.2g} | {error.max():.2g} "
                  f"| {wrong:,} | {signs:,} | {error.size:,} |", flush=True)


main()
